"""What sensors say about themselves: their kinds, ranges, steps and errors."""

from typing import Any

import pytest
from pydantic import TypeAdapter
from rig.bad_specs import bases
from rig.specs import changed, example

from heatwright.spec import Sensor, SpecError, load_text
from heatwright.spec.checks.reading import shortest_period_s
from heatwright.spec.coarseness import largest_step_k, step_at_k
from heatwright.spec.conversion import conversion
from heatwright.spec.max31856 import RANGE_C
from heatwright.spec.tree import parse


def sensor_of(text: str) -> Any:
    """Read a sensor from its entry in a file."""
    return TypeAdapter(Sensor).validate_python(parse(text, "a sensor").data)


@pytest.mark.parametrize("bits", [9, 10, 11, 12])
def test_a_ds18b20_after_its_data_sheet(bits: int) -> None:
    sensor = sensor_of(f"{{kind: ds18b20, pin: A1, resolution: {bits} bit}}")
    assert sensor.conversion_s == {9: 0.09375, 10: 0.1875, 11: 0.375, 12: 0.75}[bits]
    assert shortest_period_s(sensor) == {9: 0.15, 10: 0.24, 11: 0.43, 12: 0.8}[bits]
    assert sensor.step_k == {9: 0.5, 10: 0.25, 11: 0.125, 12: 0.0625}[bits]
    assert [sensor.error_k(t) for t in (-55, -30, -10, 85, 100, 125)] == [2, 1, 0.5, 0.5, 1, 2]


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        ("{a: 8.11e-4, b: 2.115e-4, c: 7.07e-8}", "SteinhartHartCurve"),
        ("{points: [[0 °C, 370 kΩ], [25 °C, 100 kΩ], [310 °C, 90 Ω]]}", "PointsCurve"),
        ("{resistance: 100 kΩ, at: 25 °C, beta: 3950 K}", "BetaCurve"),
    ],
)
def test_curves_are_told_by_their_keys(curve: str, expected: str) -> None:
    nozzle = "kind: thermistor, pin: A13, divider: {pull_up: 4.7 kΩ}, range: 0 °C .. 300 °C"
    sensor = sensor_of(f"{{{nozzle}, curve: {curve}}}")
    assert type(sensor.curve).__name__ == expected
    assert hash(sensor) == hash(sensor.model_copy())
    if "points" in curve:
        assert sensor.curve.points[1] == (25.0, 1e5)


@pytest.mark.parametrize("kind", RANGE_C)
def test_every_type_of_a_max31856_has_its_range(kind: str) -> None:
    lowest_c, highest_c = RANGE_C[kind]
    words = ["-10 °C may never be read"] if lowest_c > -10 else []
    words += ["1150 °C may never be read"] if highest_c < 1150 + 5 else []
    types = f"thermocouple: {kind}, selectable: [{kind}, {'R' if kind == 'S' else 'S'}]"
    kiln = changed(bases()["kiln"], ("thermocouple: K", types))
    if not words:
        assert load_text(kiln)
        return
    with pytest.raises(SpecError) as caught:
        load_text(kiln)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize("name", ["extruder", "feeder"])
def test_steps_of_the_adc(name: str) -> None:
    """The slope's step is the code's own, and the widest is what the table's computation found."""
    controller = example(name).controller
    sensor, mcu = controller.sensors["nozzle"], controller.board.mcu
    assert sensor.step_k == largest_step_k(sensor, mcu)
    assert sensor.step_k == pytest.approx(conversion(sensor, mcu).step_k)
    low_c, high_c = sensor.range_c
    for share in range(9):
        temperature_c = low_c + (high_c - low_c) * share / 8
        assert step_at_k(sensor, temperature_c, mcu) <= sensor.step_k * 1.05
        assert sensor.error_k(temperature_c) == step_at_k(sensor, temperature_c, mcu)
