"""What a spec becomes: the attributes and defaults that all other parts of the project rely on."""

from collections.abc import Mapping
from typing import Any

import pytest
from rig.bad_specs import bases
from rig.specs import example, spec_of

from heatwright.spec import (
    AfterPowerLoss,
    Autotune,
    Controller,
    Current,
    Frozen,
    Gcode,
    Heating,
    HoldBack,
    Max31855,
    Max31856,
    ModbusRtu,
    Nextion,
    OnOff,
    Pid,
    Programs,
    Radiation,
    RisingWhileOff,
    Runaway,
    SerialLog,
    ThreePosition,
    TimeProportionalOutput,
    Write,
)
from heatwright.spec.uses import pin_uses, pins_of

LEAST = bases()["oven"].replace(", power: 240 W", "")
"""The least that is a spec."""

READ: dict[str, dict[str, dict[str, object]]] = {
    LEAST: {
        "identity": {"title": None},
        "sensors.air": {"resolution_bits": 12},
        "outputs.heater": {"active": "high", "power_w": None},
        "loops.air": {"fan": None, "period_s": 1.0, "algorithm": OnOff(kind="on_off")},
        "loops.air.setpoint": {"stored": False},
        "loops.air.protection": {
            "maximum_c": 85.0, "minimum_c": -10.0, "rise_rate_k_per_s": 5.0, "stale_after_s": 5.0,
            "heating": Heating.model_validate({"rise": "2 K", "within": "120 s"}),
            "runaway": Runaway.model_validate({"above": "10 K", "for": "60 s"}),
            "frozen": Frozen.model_validate({"for": "10 min"}),
            "rising_while_off": RisingWhileOff.model_validate({"rise": "10 K", "settle": "120 s"}),
        },
        "safety": {"watchdog_s": 2.0},
        "": {"interfaces": (), "simulation": None, "comparison": ()},
    },
    "extruder": {
        "sensors.nozzle": {
            "kind": "thermistor", "range_c": (0.0, 300.0), "oversample": 4, "reference": "supply",
            "conversion_s": 0.04,
        },
        "sensors.nozzle.divider": {"pull_up_ohm": 4700.0, "pull_down_ohm": None, "supply_v": None},
        "sensors.nozzle.curve": {"resistance_ohm": 1e5, "at_c": 25, "beta_k": 4267},
        "loops.nozzle": {"ready_within_k": None, "autotune": Autotune()},
        "loops.nozzle.algorithm": {"kind": "pid", "band_k": 10.0, "dead_band_k": 0.0},
        "interfaces.0": {"baud": 115200, "loops": {"T0": "nozzle"}, "fans": {"P0": "part_fan"}},
        "simulation.scenario.0": {"send": "M104 S200", "extrude_mm_per_s": None},
        "simulation.scenario.1": {"send": None, "extrude_mm_per_s": 5.0},
        "simulation.scenario.2": {"send": None, "extrude_mm_per_s": 0.0},
        "simulation.plant.filament": {"node": "block", "heat_j_per_k_mm": 0.0056},
    },
    "feeder": {
        "sensors.nozzle": {"kind": "rtd", "element": "pt100", "divider": None, "reference": 3.3},
        "sensors.nozzle.amplifier": {"gain": 33.33, "excitation_v": 3.3, "series_ohm": 3300.0},
        "outputs.feed": {
            "kind": "stepper", "steps": 200, "microsteps": 16, "lead_mm": 25, "steps_per_mm": 128.0,
            "enable_active": "low", "maximum_mm_per_s": 20.0, "acceleration_mm_per_s2": 50.0,
        },
        "loops.nozzle": {"ready_within_k": 1.0},
        "loops.nozzle.algorithm": {"kind": "pid", "band_k": None, "dead_band_k": 0.1},
        "interfaces.0": {"kind": "gcode", "steppers": {"E": "feed"}},
    },
    "fabricator": {
        "sensors.current": {
            "kind": "current", "scale_v_per_a": 0.2, "offset_v": 0.0, "reference": "supply"
        },
        "outputs.heater": {"kind": "pwm"},
        "outputs.heater.current": {"limit_a": 3, "over_a": 3.75, "nominal_a": 3},
        "loops.nozzle": {"cooler": "cooler", "starts": "disabled"},
        "loops.nozzle.algorithm": {"kind": "three_position", "dead_band_k": 2.0},
        "interfaces.0": {
            "kind": "modbus_rtu", "address": 1, "baud": 19_200, "parity": "even", "stop_bits": 1,
            "driver_enable": None, "linuxcnc": True,
        },
        "interfaces.1": {
            "kind": "indicators", "loop": None, "active": "high",
            "leds": {
                "PB0": "enabled", "PB1": "heating", "PB2": "cooling", "PB3": "communicating"
            },
        },
        "simulation.scenario.0": {
            "write": (Write("nozzle.setpoint", 300.0), Write("nozzle.enabled", True)),
        },
        "simulation.scenario.0.write.0": {"loop": "nozzle", "what": "setpoint"},
    },
    "dryer": {"interfaces.0": {"parity": "odd", "driver_enable": "PD2", "linuxcnc": False}},
    "kiln": {
        "sensors.chamber": {
            "kind": "max31856", "thermocouple": "K", "selectable": ("K", "S"), "average": 2,
            "mains_filter_hz": 50.0, "moving_average": 5, "step_k": 1 / 128,
        },
        "outputs.element": {"kind": "time_proportional", "distribution": "burst"},
        "loops.chamber": {"starts": None},
        "loops.chamber.algorithm": {"kind": "pid", "feed_forward": 128.0},
        "loops.chamber.protection": {"maximum_adjustable": True},
        "programs": {"loop": "chamber", "points": 10, "places": 3},
        "programs.hold_back": {"within_k": 10.0},
        "programs.after_power_loss": {"resume_within_k": 30.0, "otherwise": "stop"},
        "programs.stored.0": {"name": "fuse"},
        "programs.stored.0.segments.0": {"kind": "over", "to_c": 540.0, "over_s": 3600.0},
        "programs.stored.0.segments.1": {"kind": "hold", "to_c": None, "hold_s": 1800.0},
        **{
            f"programs.stored.0.segments.{number}": {"kind": "hold" if number % 2 else "over"}
            for number in range(2, 7)
        },
        "safety": {"relay": "safety_relay", "relay_feedback": "D9"},
        "interfaces.0": {"kind": "nextion", "loop": "chamber", "baud": 115_200, "port": 0},
        "interfaces.1": {"kind": "serial_log", "port": 1, "every_s": 60.0, "keep": "ram"},
        "simulation.plant": {
            "radiation": (
                Radiation.model_validate(
                    {"between": ("brick", "ambient"), "area": "50 cm²", "emissivity": 0.3}
                ),
            )
        },
    },
}  # fmt: skip


def at(found: Any, path: str) -> Any:
    """Walk through a controller: keys, indexes and attributes, joined by points."""
    for name in path.split(".") if path else ():
        if isinstance(found, tuple) and name.isdecimal():
            found = found[int(name)]
        else:
            found = found[name] if isinstance(found, Mapping) else getattr(found, name)
    return found


def chosen(found: object, names: Mapping[str, object]) -> dict[str, object]:
    return {name: getattr(found, name) for name in names}


def controller_of(spec: str) -> Controller:
    return (spec_of(spec) if "\n" in spec else example(spec)).controller


@pytest.mark.parametrize(
    ("spec", "path"),
    [(spec, path) for spec, parts in READ.items() for path in parts],
    ids=lambda word: "least" if word == LEAST else word,
)
def test_what_a_spec_becomes(spec: str, path: str) -> None:
    expected = READ[spec][path]
    assert chosen(at(controller_of(spec), path), expected) == expected


WIRES = {"chip_select": "D2", "clock": "D3", "data_out": "D4"}


@pytest.mark.parametrize(
    ("model", "given", "expected"),
    [
        (Pid, {"kind": "pid", "kp": 5, "ki": 0.1},
         {"kd": 0.0, "derivative_of": "measurement", "derivative_filter_s": 0.0}),
        (ThreePosition, {"kind": "three_position", "dead_band": "2 K"},
         {"hysteresis_k": 0, "lead_s": 0, "lead_filter_s": 0}),
        (Autotune, {}, {"cycles": 5, "swing_percent": 100.0, "timeout_s": 1200.0}),
        (TimeProportionalOutput, {"kind": "time_proportional", "pin": "D3", "window": "1 s"},
         {"window_s": 1.0, "resolution_s": 0.01, "minimum_on_s": 0.0, "minimum_off_s": 0.0}),
        (Current, {"sensor": "wire", "limit": "4 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        (Current, {"sensor": "wire", "trip": "5 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        (ModbusRtu, {"kind": "modbus_rtu"},
         {"address": 1, "baud": 19200, "parity": "even", "stop_bits": 1, "character_bits": 11}),
        # A character has eleven bits after the standard.
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "odd"}, {"character_bits": 11}),
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "none"}, {"character_bits": 11}),
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "none", "stop_bits": 1},
         {"character_bits": 10}),
        (Nextion, {"kind": "nextion", "loop": "air"}, {"baud": 115_200, "port": 0}),
        (SerialLog, {"kind": "serial_log", "loop": "air"},
         {"baud": 115_200, "port": 0, "every_s": 60, "entries": 480, "keep": "ram"}),
        (Max31856, {"kind": "max31856", **WIRES, "data_in": "D5"},
         {"thermocouple": "K", "selectable": (), "average": 1, "mains_filter_hz": 50.0,
          "moving_average": 1}),
        (Max31855, {"kind": "max31855", "thermocouple": "T", **WIRES},
         {"range_c": (-250.0, 400.0)}),
        (Programs, {"loop": "chamber"},
         {"points": 10, "places": 3, "stored": (), "reached_within_k": 1.0, "save_every_s": 60.0,
          "at_end": "off", "hold_back": HoldBack(), "after_power_loss": AfterPowerLoss()}),
        (HoldBack, {}, {"within_k": 8.0, "limit_s": 7200.0}),
        (AfterPowerLoss, {}, {"resume_within_k": 0, "otherwise": "stop"}),
        (Gcode, {"kind": "gcode", "loops": {"T0": "air"}}, {"fans": {}, "steppers": {}}),
    ],
)  # fmt: skip
def test_what_is_not_given(model: Any, given: object, expected: dict[str, object]) -> None:
    assert chosen(model.model_validate(given), expected) == expected


def test_limits_that_are_not_given() -> None:
    pid = Pid.model_validate({"kind": "pid", "kp": 5, "ki": 0.1})
    assert (pid.integral.minimum_percent, pid.integral.maximum_percent) == (0.0, 100.0)
    assert pid.integral.while_limited == "hold"
    assert (pid.output.minimum_percent, pid.output.maximum_percent) == (0.0, 100.0)


def test_the_default_clock_waits_before_the_default_runaway() -> None:
    assert HoldBack.model_validate({}).within_k < Runaway.model_validate({}).above_k


@pytest.mark.parametrize(
    ("name", "part", "pins"),
    [
        ("extruder", "sensors.nozzle", {"pin": "A13"}),
        ("feeder", "outputs.feed", {"step": "D4", "direction": "D5", "enable": "D6"}),
    ],
)
def test_the_pins_of_a_part(name: str, part: str, pins: dict[str, str]) -> None:
    assert pins_of(at(example(name).controller, part)) == pins


@pytest.mark.parametrize(
    ("name", "pin", "path", "purpose"),
    [
        ("dryer", "PD2", "interfaces.0.driver_enable", "the line's driver"),
        ("dryer", "PD5", "interfaces.1.leds.PD5", "the LED warm"),
        ("dryer", "PD0", "interfaces.0", "the serial port"),
        ("kiln", "PH6", "safety.relay_feedback", "the relay's feedback"),
        ("kiln", "PH5", "outputs.safety_relay.pin", ""),
        *(("kiln", pin, "interfaces.0", "the serial port") for pin in ("PE0", "PE1")),
        *(("kiln", pin, "interfaces.1", "the serial port") for pin in ("PD2", "PD3")),
    ],
)
def test_every_pin_in_use_is_known(name: str, pin: str, path: str, purpose: str) -> None:
    uses = {use.pin.port_name: use for use in pin_uses(example(name).controller)}
    assert (".".join(map(str, uses[pin].path)), uses[pin].purpose) == (path, purpose)
