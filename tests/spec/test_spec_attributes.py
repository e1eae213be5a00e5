"""What a spec becomes: the attributes and defaults that all other parts of the project rely on."""

from collections.abc import Mapping
from typing import Any

import pytest
from rig.bad_specs import bases
from rig.specs import controller_of

from heatwright.spec import (
    AfterPowerLoss,
    Autotune,
    Current,
    Gcode,
    HoldBack,
    Max6675,
    Max31855,
    ModbusRtu,
    Programs,
    Runaway,
)

LEAST = bases()["oven"].replace(", power: 240 W", "")
"""The least that is a spec."""

READ: dict[str, dict[str, dict[str, object]]] = {
    LEAST: {
        "identity": {"title": None},
        "loops.air": {"fan": None, "period_s": 1.0},
        "loops.air.algorithm": {"hysteresis_k": 0.0, "lead_s": 0.0, "lead_filter_s": 0.0},
        "loops.air.protection": {
            "maximum_c": 85.0, "minimum_c": -10.0, "rise_rate_k_per_s": 5.0, "stale_after_s": 5.0,
        },
        "loops.air.protection.heating": {"rise_k": 2.0, "within_s": 120.0},
        "loops.air.protection.runaway": {"above_k": 10.0, "below_k": None, "for_s": 60.0},
        "loops.air.protection.frozen": {"for_s": 600.0},
        "loops.air.protection.rising_while_off": {"rise_k": 10.0, "settle_s": 120.0},
        "safety": {"watchdog_s": 2.0},
        "": {"interfaces": (), "simulation": None, "comparison": ()},
    },
    "extruder": {
        "sensors.nozzle": {"conversion_s": 0.04},
        "simulation.scenario.0": {"send": "M104 S200", "extrude_mm_per_s": None},
        "simulation.scenario.1": {"send": None, "extrude_mm_per_s": 5.0},
        "simulation.plant.filament": {"node": "block", "heat_j_per_k_mm": 0.0056},
    },
    "feeder": {
        "sensors.nozzle": {"divider": None, "reference": 3.3},
        "outputs.feed": {"steps": 200, "microsteps": 16, "lead_mm": 25, "steps_per_mm": 128.0},
    },
    "fabricator": {
        "outputs.heater.current": {"limit_a": 3, "over_a": 3.75, "nominal_a": 3},
        "simulation.scenario.0.write.0": {"loop": "nozzle", "what": "setpoint", "value": 300.0},
        "simulation.scenario.0.write.1": {"loop": "nozzle", "what": "enabled", "value": True},
    },
    "dryer": {"interfaces.0": {"parity": "odd", "driver_enable": "PD2", "linuxcnc": False}},
    "kiln": {
        "sensors.chamber": {"mains_filter_hz": 50.0, "moving_average": 5, "step_k": 1 / 128},
        "programs": {"places": 3},
        "simulation.plant.radiation.0": {
            "between": ("brick", "ambient"), "area_m2": 0.005, "emissivity": 0.3,
        },
    },
}  # fmt: skip
"""What shapes the committed firmware is held by the digest in it; here, what is not there."""


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
        (Autotune, {}, {"cycles": 5, "swing_percent": 100.0, "timeout_s": 1200.0}),
        (Current, {"sensor": "wire", "limit": "4 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        (Current, {"sensor": "wire", "trip": "5 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        # A character has eleven bits after the standard.
        (ModbusRtu, {"kind": "modbus_rtu"}, {"stop_bits": 1, "character_bits": 11}),
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "odd"}, {"character_bits": 11}),
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "none"}, {"character_bits": 11}),
        (ModbusRtu, {"kind": "modbus_rtu", "parity": "none", "stop_bits": 1},
         {"character_bits": 10}),
        (Max6675, {"kind": "max6675", **WIRES},
         {"range_c": (0.0, 1023.75), "step_k": 0.25, "conversion_s": 0.22, "read_s": 0.01}),
        (Max31855, {"kind": "max31855", **WIRES},
         {"range_c": (-200.0, 1350.0), "step_k": 0.25, "conversion_s": 0.1, "read_s": 0.1}),
        (Max31855, {"kind": "max31855", "thermocouple": "T", **WIRES},
         {"range_c": (-250.0, 400.0)}),
        (Programs, {"loop": "chamber"},
         {"points": 10, "places": 3, "stored": (), "hold_back": HoldBack(),
          "after_power_loss": AfterPowerLoss()}),
        (Gcode, {"kind": "gcode", "loops": {"T0": "air"}}, {"fans": {}, "steppers": {}}),
    ],
)  # fmt: skip
def test_what_is_not_given(model: Any, given: object, expected: dict[str, object]) -> None:
    """What the models' own defaults do not say; those stand in docs/language.md."""
    assert chosen(model.model_validate(given), expected) == expected


def test_the_default_clock_waits_before_the_default_runaway() -> None:
    assert HoldBack.model_validate({}).within_k < Runaway.model_validate({}).above_k
