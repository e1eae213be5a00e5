"""Coolers, currents, masters and LEDs: attributes, defaults, and what is physics of them."""

from itertools import pairwise
from pathlib import Path

import pytest

from heatwright.spec import (
    Controller,
    Current,
    CurrentSensor,
    DigitalOutput,
    Indicators,
    ModbusRtu,
    PwmOutput,
    SpecError,
    ThreePosition,
    Write,
    commanded,
    full_a,
    gcode_of,
    load,
    load_text,
    modbus_of,
    starts_enabled,
    switched,
    tunable,
)
from heatwright.spec.checks import row_controller
from heatwright.spec.checks.machine import Machine
from heatwright.spec.checks.master import exchange_s
from heatwright.spec.checks.measured import measured
from heatwright.spec.commands import zero_is_off
from heatwright.spec.controller import ComparisonRow
from heatwright.spec.interfaces import BUS_BAUDS
from heatwright.spec.uses import pin_uses
from heatwright.spec.writes import AMOUNTS, COMMANDS, GAINS, SWITCHES

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"
FABRICATOR = (EXAMPLES / "fabricator.yaml").read_text(encoding="utf-8")
DRYER = (EXAMPLES / "dryer.yaml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def fabricator() -> Controller:
    return load(EXAMPLES / "fabricator.yaml").controller


@pytest.fixture(scope="module")
def dryer() -> Controller:
    return load(EXAMPLES / "dryer.yaml").controller


def changed(text: str, *pairs: tuple[str, str]) -> Controller:
    """Another spec with some of its text replaced."""
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return load_text(text).controller


def machine_of(controller: Controller) -> Machine:
    name, loop = next(iter(controller.loops.items()))
    heater = controller.outputs[loop.heater]
    assert isinstance(heater, DigitalOutput | PwmOutput)
    assert controller.simulation is not None
    return Machine(controller, name, heater, controller.simulation)


def test_a_current_is_measured(fabricator: Controller) -> None:
    sensor = fabricator.sensors["current"]
    assert isinstance(sensor, CurrentSensor)
    assert (sensor.scale_v_per_a, sensor.offset_v, sensor.reference) == (0.2, 0.0, "supply")
    assert set(fabricator.thermometers) == {"nozzle"}
    heater = fabricator.outputs["heater"]
    assert isinstance(heater, PwmOutput)
    assert heater.current is not None
    assert (heater.current.limit_a, heater.current.over_a, heater.current.nominal_a) == (3, 3.75, 3)
    assert full_a(heater) == pytest.approx(76.6 / 43)


def test_what_the_current_is_judged_by(fabricator: Controller) -> None:
    """5 V / 1024 steps at 0.2 V/A; a code stands for the middle of its step."""
    (found,) = measured(fabricator)
    assert found.step_a == pytest.approx(5 / 1024 / 0.2)
    assert found.highest_a == pytest.approx(5 / 0.2 * 1023.5 / 1024)
    assert found.idle_a == pytest.approx(max(0.05 * 3, 3 * found.step_a))
    assert found.full_a == pytest.approx(1.7814, abs=1e-4)


@pytest.mark.parametrize(
    ("limit", "trip", "over_a", "nominal_a"), [(4.0, None, 5.0, 4.0), (None, 5.0, 5.0, 4.0)]
)
def test_a_trip_and_a_limit_follow_each_other(
    limit: float | None, trip: float | None, over_a: float, nominal_a: float
) -> None:
    texts = {"limit": limit, "trip": trip}
    given = {key: f"{value} A" for key, value in texts.items() if value is not None}
    current = Current.model_validate({"sensor": "wire", **given})
    assert (current.over_a, current.nominal_a) == (over_a, nominal_a)


def test_three_positions(fabricator: Controller) -> None:
    loop = fabricator.loops["nozzle"]
    assert isinstance(loop.algorithm, ThreePosition)
    assert loop.algorithm.dead_band_k == 2.0
    assert (loop.cooler, loop.starts) == ("cooler", "disabled")
    plain = ThreePosition.model_validate({"kind": "three_position", "dead_band": "2 K"})
    assert (plain.hysteresis_k, plain.lead_s, plain.lead_filter_s) == (0, 0, 0)


def test_a_bus(fabricator: Controller, dryer: Controller) -> None:
    bus, other = modbus_of(fabricator), modbus_of(dryer)
    assert isinstance(bus, ModbusRtu)
    assert isinstance(other, ModbusRtu)
    assert (bus.address, bus.baud, bus.parity, bus.stop_bits) == (1, 19_200, "even", 1)
    assert (bus.driver_enable, bus.linuxcnc) == (None, True)
    assert (other.parity, other.driver_enable, other.linuxcnc) == ("odd", "PD2", False)
    plain = ModbusRtu.model_validate({"kind": "modbus_rtu"})
    assert plain == ModbusRtu.model_validate({"kind": "modbus_rtu", "address": 1, "baud": 19200})


@pytest.mark.parametrize("parity", ["even", "odd", "none"])
def test_a_character_has_eleven_bits_after_the_standard(parity: str) -> None:
    bus = ModbusRtu.model_validate({"kind": "modbus_rtu", "parity": parity})
    assert bus.character_bits == 11
    short = ModbusRtu.model_validate({"kind": "modbus_rtu", "parity": "none", "stop_bits": 1})
    assert short.character_bits == 10


def test_a_master_has_every_loop(fabricator: Controller, dryer: Controller) -> None:
    for controller, name, gains in ((fabricator, "nozzle", False), (dryer, "air", True)):
        assert switched(controller, name)
        assert commanded(controller, name)
        assert tunable(controller, name) is gains
        assert not zero_is_off(controller, name)
        assert gcode_of(controller) is None
    extruder = load(EXAMPLES / "extruder.yaml").controller
    assert not switched(extruder, "nozzle")
    assert zero_is_off(extruder, "nozzle")


def test_nobody_commands_without_a_line() -> None:
    chamber = load(EXAMPLES / "chamber.yaml").controller
    assert not commanded(chamber, "air")
    assert not switched(chamber, "air")
    assert not zero_is_off(chamber, "air")


def test_leds(fabricator: Controller) -> None:
    leds = fabricator.interfaces[1]
    assert isinstance(leds, Indicators)
    assert dict(leds.leds) == {
        "PB0": "enabled", "PB1": "heating", "PB2": "cooling", "PB3": "communicating",
    }  # fmt: skip
    assert (leds.loop, leds.active) == (None, "high")


def test_every_pin_of_an_interface_is_known(dryer: Controller) -> None:
    used = {use.pin.port_name: (use.path, use.purpose) for use in pin_uses(dryer)}
    assert used["PD2"] == (("interfaces", 0, "driver_enable"), "the line's driver")
    assert used["PD5"] == (("interfaces", 1, "leds", "PD5"), "the LED warm")
    assert used["PD0"] == (("interfaces", 0), "the serial port")


def test_what_a_master_writes(fabricator: Controller) -> None:
    assert fabricator.simulation is not None
    first, *_ = fabricator.simulation.scenario
    assert first.write == (Write("nozzle.setpoint", 300.0), Write("nozzle.enabled", True))
    setpoint, enabled = first.write
    assert (setpoint.loop, setpoint.what, enabled.what) == ("nozzle", "setpoint", "enabled")
    assert (Write("store", True).loop, Write("store", True).what) == ("", "store")


@pytest.mark.parametrize("what", [*AMOUNTS, *GAINS, *SWITCHES, *COMMANDS])
def test_everything_a_master_can_write_can_be_written(what: str) -> None:
    amounts = {"setpoint": "60 °C", "manual_duty": "12.5 %"}
    value = amounts.get(what, "1.5" if what in GAINS else "true")
    name = what if what in COMMANDS else f"air.{what}"
    new = f"write: {{{name}: {value}}}"
    dryer = changed(DRYER, ("write: {air.setpoint: 70 °C, air.enabled: true}", new))
    assert dryer.simulation is not None
    assert dryer.simulation.scenario[0].write == (
        Write(
            name, {"setpoint": 60.0, "manual_duty": 12.5}.get(what, 1.5 if what in GAINS else True)
        ),
    )


def test_an_exchange_takes_its_time() -> None:
    """Two frames of 256 characters of 11 bits."""
    bus = ModbusRtu.model_validate({"kind": "modbus_rtu", "baud": 1200})
    assert exchange_s(bus) == pytest.approx(2 * 256 * 11 / 1200)


@pytest.mark.parametrize("baud", BUS_BAUDS)
@pytest.mark.parametrize("clock", ["8 MHz", "16 MHz"])
def test_usual_speeds_can_be_made(baud: int, clock: str) -> None:
    """All of them from the boards' 16 MHz; from 8 MHz all but the fastest."""
    text = DRYER.replace("baud: 38400", f"baud: {baud}")
    text = text.replace("board: atmega16", f"board: atmega16\n  clock: {clock}")
    if (clock, baud) == ("8 MHz", 115_200):
        with pytest.raises(SpecError, match="cannot be made"):
            load_text(text)
    else:
        assert load_text(text).controller


def test_a_limit_takes_power_away(fabricator: Controller) -> None:
    assert machine_of(fabricator).full_power_w == 76.6
    less = changed(FABRICATOR, ("limit: 3 A", "limit: 1.7 A"))
    assert machine_of(less).full_power_w == pytest.approx(1.7 * 43)


def test_a_cooler_cools_faster(fabricator: Controller) -> None:
    """At 320 °C the block alone falls by θ/(R·C); with the cooler by four times that.

    The sensor follows with its lag, so it never falls as fast as the block at the start.
    """
    machine = machine_of(fabricator)
    alone_k_per_s = 300 / (8 * 27)
    steepest = max(
        (before - after) / (after_s - before_s)
        for (before_s, before), (after_s, after) in pairwise(machine.cooling())
    )
    assert alone_k_per_s < steepest < 4 * alone_k_per_s


def test_held_times_count_where_they_matter() -> None:
    text = FABRICATOR.replace(
        "heater: {kind: pwm, pin: PD5, frequency: 1 kHz,", "heater: {kind: digital, pin: PD5,"
    )
    text = text.replace(", current: {sensor: current, limit: 3 A}", "")
    text = text.replace("  current: {kind: current, pin: PA1, scale: 0.2 V/A, oversample: 4}\n", "")
    text = text.replace(", current: {of: heater}", "")
    free = machine_of(load_text(text).controller)
    assert (free.held_on_s, free.held_off_s, free.cooler_held_on_s) == (0, 0, 0)
    held = machine_of(
        changed(
            text,
            ("power: 76.6 W", "power: 76.6 W, minimum_on: 300 ms, minimum_off: 2 s"),
            ("{kind: digital, pin: PD6}", "{kind: digital, pin: PD6, minimum_on: 400 ms}"),
        )
    )
    assert (held.held_on_s, held.held_off_s, held.cooler_held_on_s) == (0.3, 2.0, 0.4)
    assert max(k for _, k in held.coasting()) > max(k for _, k in free.coasting())


def test_a_row_needs_no_master(fabricator: Controller) -> None:
    row = ComparisonRow.model_validate(
        {
            "name": "wide",
            "setpoint": "200 °C",
            "algorithm": {"kind": "three_position", "dead_band": "5 K"},
        }
    )
    assert starts_enabled(row_controller(fabricator, row), "nozzle")
