"""The parts of a hotend and its host: attributes, defaults, what they say about themselves."""

from pathlib import Path

import pytest

from heatwright.spec import (
    Amplifier,
    Analog,
    Autotune,
    BetaCurve,
    Controller,
    Max6675,
    Max31855,
    Pid,
    PointsCurve,
    Rtd,
    SpecError,
    SteinhartHartCurve,
    Stepper,
    Thermistor,
    commanded,
    gcode_of,
    load,
    load_text,
    tunable,
)
from heatwright.spec.checks.reading import shortest_period_s
from heatwright.spec.coarseness import largest_step_k, step_at_k
from heatwright.spec.conversion import conversion
from heatwright.spec.uses import pins_of

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"


@pytest.fixture(scope="module")
def extruder() -> Controller:
    return load(EXAMPLES / "extruder.yaml").controller


@pytest.fixture(scope="module")
def feeder() -> Controller:
    return load(EXAMPLES / "feeder.yaml").controller


def with_sensor(sensor: str) -> Controller:
    """The extruder with another sensor."""
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    start, end = text.index("  nozzle:\n    kind"), text.index("outputs:")
    return load_text(f"{text[:start]}  nozzle: {sensor}\n\n{text[end:]}").controller


def test_a_thermistor(extruder: Controller) -> None:
    sensor = extruder.sensors["nozzle"]
    assert isinstance(sensor, Thermistor)
    assert (sensor.divider.pull_up_ohm, sensor.divider.pull_down_ohm) == (4700.0, None)
    assert sensor.divider.supply_v is None
    assert isinstance(sensor.curve, BetaCurve)
    assert (sensor.curve.resistance_ohm, sensor.curve.at_c, sensor.curve.beta_k) == (1e5, 25, 4267)
    assert (sensor.range_c, sensor.oversample, sensor.reference) == ((0.0, 300.0), 4, "supply")
    assert (sensor.conversion_s, shortest_period_s(sensor)) == (0.04, 0.04)
    assert pins_of(sensor) == {"pin": "A13"}


def test_an_rtd_behind_an_amplifier(feeder: Controller) -> None:
    sensor = feeder.sensors["nozzle"]
    assert isinstance(sensor, Rtd)
    assert isinstance(sensor.amplifier, Amplifier)
    amplifier = sensor.amplifier
    assert (amplifier.gain, amplifier.excitation_v, amplifier.series_ohm) == (33.33, 3.3, 3300.0)
    assert (sensor.element, sensor.divider, sensor.reference) == ("pt100", None, 3.3)


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        ("{a: 8.11e-4, b: 2.115e-4, c: 7.07e-8}", SteinhartHartCurve),
        ("{points: [[0 °C, 370 kΩ], [25 °C, 100 kΩ], [310 °C, 90 Ω]]}", PointsCurve),
        ("{resistance: 100 kΩ, at: 25 °C, beta: 3950 K}", BetaCurve),
    ],
)
def test_curves_are_told_by_their_keys(curve: str, expected: type) -> None:
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    text = text.replace("curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}", f"curve: {curve}")
    text = text.replace("rise_rate: 20 K/s", "rise_rate: 40 K/s")
    sensor = load_text(text).controller.sensors["nozzle"]
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


def test_converters_of_thermocouples() -> None:
    wires = "chip_select: D22, clock: D24, data_out: D26"
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    start, end = text.index("  nozzle:\n    kind"), text.index("outputs:")
    for kind, period, least_s, highest_c in (
        ("max6675", "230 ms", 0.23, 1023.75),
        ("max31855", "200 ms", 0.2, 1350.0),
    ):
        changed = f"{text[:start]}  nozzle: {{kind: {kind}, {wires}}}\n{text[end:]}"
        changed = changed.replace("period: 100 ms", f"period: {period}")
        changed = changed.replace("minimum: 5 °C", "minimum: 6 °C")
        sensor = load_text(changed).controller.sensors["nozzle"]
        assert isinstance(sensor, Max6675 | Max31855)
        assert pins_of(sensor) == {"chip_select": "D22", "clock": "D24", "data_out": "D26"}
        assert (sensor.step_k, shortest_period_s(sensor)) == (0.25, least_s)
        assert sensor.range_c[1] == highest_c


def test_a_thermocouple_has_its_type() -> None:
    types = {}
    for letter in "KJNTSRE":
        sensor = Max31855.model_validate(
            {
                "kind": "max31855",
                "thermocouple": letter,
                "chip_select": "D2",
                "clock": "D3",
                "data_out": "D4",
            }
        )
        types[letter] = sensor.range_c
        assert sensor.range_c[0] < 0 < sensor.range_c[1]
    assert types["T"] == (-250.0, 400.0)


def test_steps_of_the_adc(extruder: Controller, feeder: Controller) -> None:
    """The slope's step is the code's own, and the widest is what the table's computation found."""
    for controller in (extruder, feeder):
        sensor, mcu = controller.sensors["nozzle"], controller.board.mcu
        assert sensor.step_k == largest_step_k(sensor, mcu)
        assert sensor.step_k == pytest.approx(conversion(sensor, mcu).step_k)
        low_c, high_c = sensor.range_c
        for share in range(9):
            temperature_c = low_c + (high_c - low_c) * share / 8
            assert step_at_k(sensor, temperature_c, mcu) <= sensor.step_k * 1.05
            assert sensor.error_k(temperature_c) == step_at_k(sensor, temperature_c, mcu)


def test_a_stepper(feeder: Controller) -> None:
    feed = feeder.outputs["feed"]
    assert isinstance(feed, Stepper)
    assert pins_of(feed) == {"step": "D4", "direction": "D5", "enable": "D6"}
    assert (feed.steps, feed.microsteps, feed.lead_mm, feed.enable_active) == (200, 16, 25, "low")
    assert (feed.maximum_mm_per_s, feed.acceleration_mm_per_s2) == (20.0, 50.0)
    assert feed.steps_per_mm == 128.0


def test_a_host(extruder: Controller, feeder: Controller) -> None:
    gcode = gcode_of(extruder)
    assert gcode is not None
    assert (gcode.baud, dict(gcode.loops), dict(gcode.fans)) == (
        115200,
        {"T0": "nozzle"},
        {"P0": "part_fan"},
    )
    assert commanded(extruder, "nozzle")
    assert tunable(extruder, "nozzle")
    assert dict(getattr(gcode_of(feeder), "steppers", {})) == {"E": "feed"}
    chamber = load(EXAMPLES / "chamber.yaml").controller
    assert gcode_of(chamber) is None
    assert not commanded(chamber, "air")
    assert not tunable(chamber, "air")


def test_on_off_is_commanded_and_has_no_gains() -> None:
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    start, end = text.index("    algorithm:"), text.index("    protection:")
    controller = load_text(
        f"{text[:start]}    algorithm: {{kind: on_off}}\n{text[end:]}"
    ).controller
    assert commanded(controller, "nozzle")
    assert not tunable(controller, "nozzle")


def test_bands_and_the_experiment(extruder: Controller, feeder: Controller) -> None:
    loop = extruder.loops["nozzle"]
    assert isinstance(loop.algorithm, Pid)
    assert (loop.algorithm.band_k, loop.algorithm.dead_band_k) == (10.0, 0.0)
    assert loop.autotune == Autotune.model_validate({})
    assert (loop.autotune.cycles, loop.autotune.swing_percent, loop.autotune.timeout_s) == (
        5,
        100.0,
        1200.0,
    )
    other = feeder.loops["nozzle"]
    assert isinstance(other.algorithm, Pid)
    assert (other.algorithm.band_k, other.algorithm.dead_band_k) == (None, 0.1)
    assert (loop.ready_within_k, other.ready_within_k) == (None, 1.0)


def test_supply_and_rated() -> None:
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    assert "power: 40 W, supply: 12 V" in text
    for rated, share in (("", 1.0), (", rated: 12 V", 1.0), (", rated: 6 V", 0.25)):
        controller = load_text(text.replace("supply: 12 V", f"supply: 12 V{rated}")).controller
        heater = controller.outputs["heater"]
        assert getattr(heater, "full_share", None) == share


def test_zero_is_a_hosts_word_for_off() -> None:
    """A commanded loop may begin at 0 °C although it cannot be set so low."""
    text = (EXAMPLES / "extruder.yaml").read_text(encoding="utf-8")
    narrow = text.replace("initial: 0 °C, minimum: 0 °C", "initial: 0 °C, minimum: 170 °C")
    assert load_text(narrow).controller.loops["nozzle"].setpoint.initial_c == 0.0
    alone = narrow.replace("kind: gcode, baud: 115200, loops: {T0: nozzle}", "kind: serial_plotter")
    with pytest.raises(SpecError):
        load_text(alone)


def test_an_amplifier_that_saturates_below_the_maximum_is_refused() -> None:
    text = (EXAMPLES / "feeder.yaml").read_text(encoding="utf-8")
    for old, new, reason in (
        ("2 °C .. 262 °C", "2 °C .. 264 °C", "the circuit shows 1 °C to 262 °C"),
        ("maximum: 260 °C", "maximum: 270 °C", "270 °C may never be read"),
    ):
        assert old in text
        with pytest.raises(SpecError, match=reason):
            load_text(text.replace(old, new))


def test_events_feed_and_send(extruder: Controller) -> None:
    assert extruder.simulation is not None
    events = extruder.simulation.scenario
    assert [event.send for event in events] == ["M104 S200", None, None, None]
    assert [event.extrude_mm_per_s for event in events] == [None, 5.0, 0.0, None]
    filament = extruder.simulation.plant.filament
    assert filament is not None
    assert (filament.node, filament.heat_j_per_k_mm) == ("block", 0.0056)
