"""The examples' machines, off by some; runs of their models, and of their binaries, each once."""

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from rig.firmware import controller_of as example
from rig.firmware import whole

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.healthy import scaled as scaled_network
from heatwright.sim.interfaces.indicators import Indicators
from heatwright.sim.reference.inputs import Gains
from heatwright.sim.trace import Trace
from heatwright.sim.tuning import gains as tuning
from heatwright.sim.tuning.margins import Margins, margins
from heatwright.sim.tuning.process import process_of
from heatwright.spec import Controller, Event
from heatwright.spec.base import ReadOnlyDict

OFF_BY = (1.0, 0.7, 1.3)
PLANTS = [(capacity, resistance) for capacity in OFF_BY for resistance in OFF_BY]
Lines = tuple[Mapping[str, Any], ...]


def events(*lines: Mapping[str, Any]) -> list[Event]:
    return [Event.model_validate(line) for line in lines]


def at(said: Mapping[float, Any], verb: str = "send") -> Lines:
    return tuple({"at": f"{time_s} s", verb: line} for time_s, line in said.items())


def on_plant(controller: Controller, **changes: Any) -> Controller:
    plant = controller.simulated.plant.model_copy(update=changes)
    simulation = controller.simulated.model_copy(update={"plant": plant})
    return controller.model_copy(update={"simulation": simulation})


def scaled(controller: Controller, capacity: float, resistance: float) -> Controller:
    """The same controller on a machine whose capacity and resistance are so many times as large."""
    plant = scaled_network(controller.simulated.plant, capacity, resistance)
    return on_plant(controller, nodes=plant.nodes, links=plant.links)


def noisy(controller: Controller, noise_k: float) -> Controller:
    sense = controller.simulated.plant.sense
    changed = {name: each.model_copy(update={"noise_k": noise_k}) for name, each in sense.items()}
    return on_plant(controller, sense=ReadOnlyDict(changed))


def assert_margins(
    controller: Controller, gains: Gains | None = None, at_c: float | None = None, *,
    gain: float = 2.0, phase_deg: float = 45.0,
) -> Margins:  # fmt: skip
    """See that the only loop keeps what every tuned loop here is held to; return its margins."""
    ((name, loop),) = controller.loops.items()
    own = loop.algorithm
    kp, ki, kd = map(float, gains or (own.kp, own.ki, own.kd))
    parallel = tuning.Gains(kp, ki, kd, own.derivative_filter_s)
    found = margins(process_of(controller, name, at_c), parallel, loop.period_s)
    assert found.stable
    assert found.gain >= gain
    assert found.phase_deg >= phase_deg
    return found


class Run(NamedTuple):
    controller: Controller
    device: Any
    trace: Trace

    @property
    def log(self) -> Any:
        (log,) = self.trace.steps.values()
        return log

    def between(self, from_s: float, to_s: float) -> Any:
        return self.log[(self.log["time_s"] > from_s) & (self.log["time_s"] < to_s)]


def run_on(device: Any, controller: Controller, lines: Lines, seed: int = 0) -> Run:
    trace = bench(controller, device, events(*lines) if lines else None, seed=seed)
    return Run(controller, device, trace)


def modelled(controller: Controller | str, *lines: Mapping[str, Any], seed: int = 0) -> Run:
    found = example(controller) if isinstance(controller, str) else controller
    return run_on(ReferenceDevice(found), found, lines, seed)


def course(log: Any, *names: str) -> list[tuple[Any, ...]]:
    """What members of the log are, each time one of them changes."""
    rows = [tuple(log[name][row].item() for name in names) for row in range(len(log))]
    return [row for row, before in zip(rows, [None, *rows], strict=False) if row != before]


@cache
def tuned(name: str, target_c: float, capacity: float, resistance: float) -> Run:
    controller = scaled(example(name), capacity, resistance)
    return modelled(controller, *at({1: f"M303 S{target_c:g}"}), {"for": "500 s"})


TUNED_S = 400.0  # by then a tuning from cold has ended
SET_S, ON_S, COOLER_S, OFF_S, END_S = ACCEPTED_S = 1.0, 10.0, 210.0, 520.0, 530.0
HOT_C, MILD_C = 300.0, 30.0
LOOK_S = 1.0


class Watched(AvrDevice):
    """A board with somebody who looks at its LEDs and at the master's panel every second."""

    def __init__(self, *given: Any) -> None:
        self.lights: dict[float, dict[str, str]] = {}
        self.panel: dict[float, dict[str, float]] = {}
        super().__init__(*given)

    @property
    def is_attended(self) -> bool:
        return True

    def listen(self) -> None:
        super().listen()
        if self.time_s >= len(self.lights) * LOOK_S:
            self.feed()
            (leds,) = (each for each in self.interfaces if isinstance(each, Indicators))
            self.lights[self.time_s] = leds.lights()
            self.panel[self.time_s] = dict(self.master.values)


def written(at_s: float, **values: Any) -> dict[str, Any]:
    """A line of a scenario; `air__setpoint` is the name `air.setpoint`."""
    names = {name.replace("__", "."): value for name, value in values.items()}
    return {"at": f"{at_s} s", "write": names}


ACCEPTANCE: Lines = (
    written(SET_S, nozzle__setpoint=f"{HOT_C} °C"), written(ON_S, nozzle__enabled=True),
    written(COOLER_S, nozzle__setpoint=f"{MILD_C} °C"), written(OFF_S, nozzle__enabled=False),
    {"for": f"{END_S} s"},
)  # fmt: skip
DRYER: Lines = (
    written(2, air__setpoint="50 °C", air__enabled=True), written(10, air__manual_duty="30 %"),
    written(12, air__manual=True), written(20, air__manual_duty="60 %"),
    written(25, air__manual=False), written(30, air__kp=30.0, air__ki=0.1, air__kd=100.0),
    written(40, air__setpoint="81 °C"),  # refused: too high
    written(41, air__setpoint="60 °C"), written(50, air__enabled=False),
    written(55, air__manual=True), written(56, air__tune=True),  # refused: off
    written(60, air__enabled=True), written(65, air__tune=True),
    written(67, air__setpoint="55 °C"),  # refused: another target
    written(68, air__setpoint="60 °C"), written(80, air__tune=False),
    written(90, air__enabled=True), written(100, air__tune=True),
    written(110, air__enabled=False), {"for": "120 s"},
)  # fmt: skip
REFUSED = {40: "air.setpoint", 55: "air.manual", 56: "air.tune", 67: "air.setpoint"}
EXTRUDER: Lines = (
    *at({1: "M303 S200 C5", TUNED_S: "M106 S255"}),  # then it is cooled down
    *at({1400: "M107", 1500: "M104 S200"}),
    *at({1700: "5 mm/s", 1760: "0 mm/s"}, "extrude"),
    {"for": "1900 s"},
)
HOSTED: Lines = (
    *at({1: "M104 S200", 2: "M104 S0", 3: "M104 S200", 4: "M104 S261", 5: "M104 S-5", 6: "M104"}),
    *at({7: "M104 D101", 8: "M303 S0", 9: "M108", 10: "M104 D30", 12: "M104 S200", 13: "M112"}),
    *at({14: "M104 S210", 15: "M303 S210", 16: "M104 D10", 17: "M999", 20: "M104 S200"}),
    *at({21: "M301 P5 I0.25", 22: "M301 P-1", 23: "M301 I2000000", 24: "M104 S210.5"}),
    *at({25: "M106 P0 S127.5", 27: "M107", 28: "M303 S200 C3"}),  # it ends only after the run
    {"for": "30 s"},
)
FEED_MM_PER_S, HOLD_S = 5.0, 300.0  # HOLD_S: time to heat up and settle
PHASES = tuple(
    (target_c, feeds, TUNED_S + 1.0 + HOLD_S * (2 * number + feeds))
    for number, target_c in enumerate(range(180, 251, 10))
    for feeds in (False, True)
)
"""Stretches of the tuned feeder: target (°C), whether it feeds, from when on (s)."""
FED = f"G1 E{FEED_MM_PER_S * HOLD_S:g} F{60 * FEED_MM_PER_S:g}"
FEEDER: Lines = (
    *at({1: "M303 S210 C5", TUNED_S: "M83"}),
    *at({at_s: FED if feeds else f"M104 S{target_c}" for target_c, feeds, at_s in PHASES}),
    {"for": f"{PHASES[-1][2] + HOLD_S} s"},
)
POINTS: Lines = (
    *at({3: "#13 2;", 4: "#7 1,0h20,600:2,40,300:3,1h,300:4,0,0:;", 8: "#8 2;"}),
    {"for": "4 h"},
)
ORDERS: Lines = (
    *at({5: "start 1", 600: "pause", 700: "resume", 1000: "skip", 1100: "jump 3"}, "program"),
    *at({1101.5: "pause", 1200: "jump 1", 1300: "resume", 1900: "start 1"}, "program"),  # it runs
    *at({2000: "stop", 2010: "pause", 2020: "start 1"}, "program"),  # there is nothing to pause
    {"for": "2100 s"},
)
RUNS: dict[str, tuple[str, Lines]] = {
    "extruder": ("extruder", EXTRUDER), "extruder, ordered about": ("extruder", HOSTED),
    "feeder": ("feeder", FEEDER), "fabricator": ("fabricator", ACCEPTANCE),
    "dryer": ("dryer", DRYER), "kiln, its own program": ("kiln", ()),
    "kiln, the source's points": ("kiln", POINTS), "kiln, ordered about": ("kiln", ORDERS),
    "kiln_uno, by its keys": ("kiln_uno", ()),
}  # fmt: skip
"""The example, and what it is told; nothing: its own scenario."""


@cache
def run_of(name: str) -> Run:
    (kind, lines), watched = RUNS[name], name == "fabricator"
    device = (Watched if watched else AvrDevice)(example(kind), whole(kind))
    return run_on(device, example(kind), lines)
