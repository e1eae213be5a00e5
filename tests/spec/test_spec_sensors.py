"""What sensors say about themselves: their kinds, ranges, steps and errors."""

import pytest
from rig.specs import EXAMPLES, example

from heatwright.spec import (
    Analog,
    BetaCurve,
    Controller,
    Max31855,
    PointsCurve,
    Sensor,
    SpecError,
    SteinhartHartCurve,
    Thermistor,
    full_a,
    kinds,
    load_text,
)
from heatwright.spec.checks.reading import shortest_period_s
from heatwright.spec.coarseness import largest_step_k, step_at_k
from heatwright.spec.conversion import conversion
from heatwright.spec.max31856 import RANGE_C
from heatwright.spec.uses import pins_of

CURVE = "{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}"


def changed(name: str, *pairs: tuple[str, str]) -> Controller:
    """An example with some of its text replaced."""
    text = (EXAMPLES / f"{name}.yaml").read_text("utf-8")
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return load_text(text).controller


def with_sensor(sensor: str, *pairs: tuple[str, str]) -> Controller:
    """The extruder with another sensor."""
    text = (EXAMPLES / "extruder.yaml").read_text("utf-8")
    own = text[text.index("  nozzle:\n    kind") : text.index("outputs:")]
    return changed("extruder", (own, f"  nozzle: {sensor}\n\n"), *pairs)


@pytest.mark.parametrize("bits", [9, 10, 11, 12])
def test_a_ds18b20_after_its_data_sheet(bits: int) -> None:
    (sensor,) = changed(
        "chamber", ("resolution: 12 bit", f"resolution: {bits} bit")
    ).sensors.values()
    assert sensor.conversion_s == {9: 0.09375, 10: 0.1875, 11: 0.375, 12: 0.75}[bits]
    assert shortest_period_s(sensor) == {9: 0.15, 10: 0.24, 11: 0.43, 12: 0.8}[bits]
    assert sensor.step_k == {9: 0.5, 10: 0.25, 11: 0.125, 12: 0.0625}[bits]
    assert [sensor.error_k(t) for t in (-55, -30, -10, 85, 100, 125)] == [2, 1, 0.5, 0.5, 1, 2]


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        ("{a: 8.11e-4, b: 2.115e-4, c: 7.07e-8}", SteinhartHartCurve),
        ("{points: [[0 °C, 370 kΩ], [25 °C, 100 kΩ], [310 °C, 90 Ω]]}", PointsCurve),
        ("{resistance: 100 kΩ, at: 25 °C, beta: 3950 K}", BetaCurve),
    ],
)
def test_curves_are_told_by_their_keys(curve: str, expected: type) -> None:
    found = changed(
        "extruder",
        (f"curve: {CURVE}", f"curve: {curve}"),
        ("rise_rate: 20 K/s", "rise_rate: 40 K/s"),
    )
    sensor = found.sensors["nozzle"]
    assert isinstance(sensor, Thermistor)
    assert type(sensor.curve) is expected
    assert hash(sensor) == hash(sensor.model_copy())
    if isinstance(sensor.curve, PointsCurve):
        assert sensor.curve.points[1] == (25.0, 1e5)


def test_an_analog_sensor() -> None:
    sensor = with_sensor(
        "{kind: analog, pin: A9, scale: 10 mV/K, offset: 0.1 V, range: 0 °C .. 300 °C}"
    ).sensors["nozzle"]
    assert isinstance(sensor, Analog)
    assert (sensor.scale_v_per_k, sensor.offset_v, sensor.open_reads) == (0.01, 0.1, "low")
    assert (sensor.oversample, sensor.conversion_s) == (1, 0.01)
    assert sensor.step_k == pytest.approx(5 / 1024 / 0.01)
    assert sensor.error_k(100) == pytest.approx(sensor.step_k)


@pytest.mark.parametrize(
    ("kind", "period", "least_s", "highest_c"),
    [("max6675", "230 ms", 0.23, 1023.75), ("max31855", "200 ms", 0.2, 1350.0)],
)
def test_converters_of_thermocouples(
    kind: str, period: str, least_s: float, highest_c: float
) -> None:
    sensor = with_sensor(
        f"{{kind: {kind}, chip_select: D22, clock: D24, data_out: D26}}",
        ("period: 100 ms", f"period: {period}"),
        ("minimum: 5 °C", "minimum: 6 °C"),
    ).sensors["nozzle"]
    assert sensor.kind == kind
    assert pins_of(sensor) == {"chip_select": "D22", "clock": "D24", "data_out": "D26"}
    assert (sensor.step_k, shortest_period_s(sensor)) == (0.25, least_s)
    assert sensor.range_c[1] == highest_c


@pytest.mark.parametrize("letter", "KJNTSRE")
def test_a_max31855_has_its_type(letter: str) -> None:
    wires = {"chip_select": "D2", "clock": "D3", "data_out": "D4"}
    sensor = Max31855.model_validate({"kind": "max31855", "thermocouple": letter, **wires})
    assert sensor.range_c[0] < 0 < sensor.range_c[1]


@pytest.mark.parametrize("kind", RANGE_C)
def test_every_type_of_a_max31856_has_its_range(kind: str) -> None:
    lowest_c, highest_c = RANGE_C[kind]
    words = ["-10 °C may never be read"] if lowest_c > -10 else []
    words += ["1150 °C may never be read"] if highest_c < 1150 + 5 else []
    types = f"selectable: [{kind}, {'R' if kind == 'S' else 'S'}]"
    pairs = (("thermocouple: K", f"thermocouple: {kind}"), ("selectable: [K, S]", types))
    if not words:
        assert changed("kiln", *pairs)
        return
    with pytest.raises(SpecError) as caught:
        changed("kiln", *pairs)
    assert all(word in str(caught.value) for word in words)


@pytest.mark.parametrize("kind", [kind for kind in kinds(Sensor) if kind != "current"])
def test_every_thermometer_can_be_averaged(kind: str) -> None:
    assert kinds(Sensor)[kind].model_fields["moving_average"].default == 1


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


def test_a_current_is_no_temperature() -> None:
    fabricator = example("fabricator").controller
    assert set(fabricator.thermometers) == {"nozzle"}
    assert full_a(fabricator.outputs["heater"]) == pytest.approx(76.6 / 43)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("rated", "share"), [("", 1.0), (", rated: 12 V", 1.0), (", rated: 6 V", 0.25)]
)
def test_what_a_heater_is_rated_for(rated: str, share: float) -> None:
    heater = changed("extruder", ("supply: 12 V", f"supply: 12 V{rated}")).outputs["heater"]
    assert getattr(heater, "full_share", None) == share
