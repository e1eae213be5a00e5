"""The binaries themselves: tuned by their host, then held to what the machines are promised.

What the reference does on nine machines (test_tuning_holds.py) the firmware does on the nominal
one, and every step of it, the tuning included, is replayed bit for bit.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from machines import events, example

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.bench import bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.metrics import metrics
from heatwright.sim.replay import replay
from heatwright.sim.trace import Trace
from heatwright.spec import load

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
LOOP = "nozzle"
TUNED_S = 400.0
"""By then a tuning from cold has ended."""
DONE = 2

EXTRUDER: tuple[dict[str, Any], ...] = (
    {"at": "1 s", "send": "M303 S200 C5"},
    {"at": f"{TUNED_S:g} s", "send": "M106 S255"},  # cools it down
    {"at": "1400 s", "send": "M107"},
    {"at": "1500 s", "send": "M104 S200"},
    {"at": "1700 s", "extrude": "5 mm/s"},
    {"at": "1760 s", "extrude": "0 mm/s"},
    {"for": "1900 s"},
)
FEEDER: tuple[dict[str, Any], ...] = (
    {"at": "1 s", "send": "M303 S210 C5"},
    {"at": f"{TUNED_S:g} s", "send": "M104 S180"},
    {"at": "700 s", "send": "M83"},
    {"at": "701 s", "send": "G1 E1500 F300"},
    {"at": "1100 s", "send": "M104 S250"},
    {"at": "1500 s", "send": "G1 E1500 F300"},
    {"for": "1800 s"},
)
FEEDER_STEADY = ((600, 700, 180, 0.0), (900, 1000, 180, 5.0), (1400, 1500, 250, 0.0),
                 (1700, 1800, 250, 5.0))  # fmt: skip
"""From, to (s), target (°C) and feed (mm/s)."""
PUBLISHED_LOW_K, PUBLISHED_HIGH_K = -0.8, 0.9
AIM_K = 0.3


class Told:
    """A binary that has been through a scenario."""

    def __init__(self, name: str, lines: tuple[dict[str, Any], ...], folder: Path) -> None:
        spec = load(EXAMPLES / f"{name}.yaml")
        write(render(plan_firmware(spec)), folder)
        self.controller = spec.controller
        self.device = AvrDevice(spec.controller, build(folder).elf)
        self.trace: Trace = bench(self.controller, self.device, events(*lines))
        self.log = self.trace.steps[LOOP]

    def between(self, start_s: float, end_s: float, member: str) -> Any:
        inside = (self.log["time_s"] > start_s) & (self.log["time_s"] < end_s)
        return self.log[member][inside]


@pytest.fixture(scope="module")
def extruder(tmp_path_factory: pytest.TempPathFactory) -> Told:
    return Told("extruder", EXTRUDER, tmp_path_factory.mktemp("extruder"))


@pytest.fixture(scope="module")
def feeder(tmp_path_factory: pytest.TempPathFactory) -> Told:
    return Told("feeder", FEEDER, tmp_path_factory.mktemp("feeder"))


@pytest.mark.parametrize("name", ["extruder", "feeder"])
def test_every_step_is_the_models(name: str, request: pytest.FixtureRequest) -> None:
    told: Told = request.getfixturevalue(name)
    result = replay(told.controller, told.log)
    assert result.ticks == len(told.log)
    assert (result.mismatches, result.restored) == (0, ())
    assert set(told.log["fault.code"]) == {0}


@pytest.mark.parametrize("name", ["extruder", "feeder"])
def test_the_host_tunes_it(name: str, request: pytest.FixtureRequest) -> None:
    told: Told = request.getfixturevalue(name)
    done = told.log[np.searchsorted(told.log["time_s"], TUNED_S) - 1]
    assert done["autotune.result"] == DONE
    assert done["setpoint_c"] == 0  # off, until it is told to heat
    for gain in ("kp", "ki", "kd"):
        assert told.device.read(f"settings.{LOOP}_{gain}") == done[f"autotune.{gain}"]
        assert told.log[f"algorithm.{gain}"][-1] == done[f"autotune.{gain}"]
    assert told.device.host.texts("PID Autotune finished!")


def test_the_gains_outlive_the_power(extruder: Told, tmp_path: Path) -> None:
    again = Told("extruder", (*EXTRUDER[:1], {"for": f"{TUNED_S:g} s"}), tmp_path)
    kp = again.device.read(f"settings.{LOOP}_kp")
    assert kp != np.float32(example("extruder").loops[LOOP].algorithm.kp)
    again.device.power_cycle()
    again.device.advance(again.device.time_s + 1.0)
    assert again.device.read(f"settings.{LOOP}_kp") == kp
    assert again.device.read(f"settings.{LOOP}_setpoint_c") == 0


def test_the_extruder_from_cold(extruder: Told) -> None:
    assert extruder.between(1499, 1500, "temperature_c").max() < 30
    assert 0 < extruder.between(1500, 1700, "temperature_c").max() - 200 <= 1.0


def test_the_extruder_under_filament(extruder: Told) -> None:
    assert 200 - extruder.between(1700, 1760, "temperature_c").min() <= 2.0
    back = metrics(extruder.trace, extruder.controller).disturbances[0]
    assert back.what == "extrude 5 mm/s"
    assert back.recovered_after_s is not None
    assert back.recovered_after_s <= 20.0


@pytest.mark.parametrize(("start_s", "end_s", "target_c", "feed_mm_per_s"), FEEDER_STEADY)
def test_the_feeder_holds(
    feeder: Told, start_s: float, end_s: float, target_c: float, feed_mm_per_s: float
) -> None:
    errors_k = feeder.between(start_s, end_s, "temperature_c") - target_c
    assert PUBLISHED_LOW_K < errors_k.min() <= errors_k.max() < PUBLISHED_HIGH_K
    assert abs(errors_k).max() <= AIM_K
    inside = (feeder.trace.times_s > start_s) & (feeder.trace.times_s < end_s)
    assert feeder.trace.fed_mm_per_s[inside].mean() == pytest.approx(feed_mm_per_s, rel=0.01)
