"""The list by which a machine is started: its values are those of the simulation and the spec."""

import re
from itertools import chain
from pathlib import Path

import pytest
from rig.controllers import drawn
from rig.specs import EXAMPLES, changed, example, files_of, spec_of
from suite import amount

from heatwright.generator import plan_firmware
from heatwright.generator.plan.documents.commissioning import Stage, Step
from heatwright.sim.circuits.ports import pin_v
from heatwright.spec import Spec

NAMES = sorted(path.stem for path in Path(EXAMPLES).glob("*.yaml"))


def stages(spec: Spec) -> list[Stage]:
    files = {file.path: file.told for file in plan_firmware(spec).files}
    found: list[Stage] = files["README.md"].commissioning
    return found


def steps(spec: Spec) -> dict[str, str]:
    return {step.do: step.see for step in chain(*(stage.steps for stage in stages(spec)))}


def seen(spec: Spec, start: str) -> str:
    (found,) = (see for do, see in steps(spec).items() if do.startswith(start))
    return found


@pytest.mark.parametrize("name", NAMES)
def test_the_voltage_at_a_pin_is_the_simulations(name: str) -> None:
    controller = example(name).controller
    for sensor in controller.adc_sensors.values():
        if sensor.measures_current:
            continue
        pin = controller.board.pins[sensor.pin].name
        (told,) = re.findall(r"about ([\d.]+) V", seen(example(name), f"Measure {pin}"))
        assert float(told) == pytest.approx(float(pin_v(sensor, 20.0)), rel=5e-3)


@pytest.mark.parametrize("name", NAMES)
def test_a_torn_sensor_is_told_as_soon_as_the_hazards_say(name: str) -> None:
    """A test holds these to the simulation."""
    readme = files_of(name)["README.md"]
    (row,) = re.findall(r"^\| The sensor is torn.*", readme, re.MULTILINE)
    latest = max(float(each) for each in re.findall(r"E\d\d ([\d.]+) s", row))
    told = [
        float(re.findall(r"within ([\d.]+) s", see)[0])
        for do, see in steps(example(name)).items()
        if do.endswith("on: pull the sensor's plug")
    ]
    assert max(told) == pytest.approx(latest, rel=5e-3)


def test_a_heater_has_the_resistance_of_its_power() -> None:
    assert seen(example("fabricator"), "Measure heater") == "8.54 Ω ± 10 %"
    assert seen(example("kiln"), "Measure heater").endswith("109 Ω at 230 V (± 10 %)")


def test_the_level_of_rest_is_that_at_which_nothing_conducts() -> None:
    """The kiln's triac is lit by a low pin."""
    held = "Hold the reset button, and let it go: measure "
    assert seen(example("kiln"), f"{held}D2 = PE4") == "5 V all the time"
    assert seen(example("chamber"), f"{held}D3 = PD3") == "0 V all the time"
    assert not [do for do in steps(example("chamber")) if "`fan`)" in do], "it runs always"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("chamber", "`air` is on again, at 20 °C"),
        (changed("chamber", ("maximum: 70 °C}", "maximum: 70 °C, stored: true}")), "of before"),
        ("kiln", "`chamber` is off until somebody switches it on"),
        ("extruder", "`nozzle` is off until somebody switches it on"),
    ],
)
def test_what_comes_back_with_the_power_is_told(text: str, told: str) -> None:
    spec = spec_of(text) if "\n" in text else example(text)
    assert seen(spec, "Take all power away").endswith(told)


def test_the_loads_have_no_power_before_all_that_switches_them_off_was_seen() -> None:
    for spec in (*map(example, NAMES), *(each.spec for each in drawn(amount("drawn_models")))):
        found = stages(spec)
        assert [stage.title.partition(":")[0] for stage in found] == [
            "Nothing has power", "The board has power, the loads have none",
            "A lamp in the place of each heater", "The first heating",
        ]  # fmt: skip
        assert all(isinstance(step, Step) and step.see for stage in found for step in stage.steps)
        for loop in spec.controller.loops.values():
            assert any(f"`{loop.heater}`" in step.do for step in found[0].steps)
            assert any(f"`{loop.heater}`" in step.do for step in found[1].steps)
