"""What a spec becomes: the attributes and defaults that all other parts of the project rely on."""

import re
from collections.abc import Mapping
from typing import Any

import pytest
from rig.bad_specs import bases
from rig.firmware import changed, controller_of, example

import heatwright.spec as language
from heatwright.spec import (
    ComparisonRow,
    SpecError,
    Write,
    commands,
    facts_of,
    load_text,
    row_controller,
)
from heatwright.spec.checks.sensing.reading import shortest_period_s
from heatwright.spec.rules import RULES
from heatwright.spec.scenario.writes import AMOUNTS, COMMANDS, GAINS, SWITCHES

LEAST = changed(bases()["oven"], (", power: 240 W", ""))
RULES_OFF = "{maximum: 80 °C, heating: off, runaway: off, frozen: off, rising_while_off: off}"
TEXTS = {
    "least": LEAST,
    "slow": changed(LEAST, ("uno", "uno, clock: 8 MHz"), ("maximum: 70 °C", "maximum: 60 °C")),
    "rated": changed("extruder", ("supply: 12 V", "supply: 12 V, rated: 6 V")),
    "analog": bases()["analog_extruder"],
    "off": f"{LEAST}    protection: {RULES_OFF}\n",
}  # the least that is a spec, and what is changed in it

READ: dict[str, dict[str, dict[str, object]]] = {
    "least": {
        "identity": {"title": None}, "board": {"clock_hz": 16_000_000},
        "loops.air": {"fan": None, "period_s": 1.0},
        "loops.air.protection": {
            "maximum_c": 85.0, "minimum_c": -10.0, "rise_rate_k_per_s": 5.0, "stale_after_s": 5.0,
        },
        "loops.air.protection.heating": {"rise_k": 2.0, "within_s": 120.0},
        "loops.air.protection.runaway": {"above_k": 10.0, "below_k": None, "for_s": 60.0},
        "loops.air.protection.frozen": {"for_s": 600.0},
        "loops.air.protection.rising_while_off": {"rise_k": 10.0, "settle_s": 120.0},
        "": {"interfaces": (), "simulation": None, "comparison": ()},
    },
    "slow": {
        "identity": {"clock_hz": 8e6}, "board": {"clock_hz": 8_000_000, "clock_hz.__class__": int},
        "loops.air.protection": {"maximum_c": 75.0},
    },
    "off": {
        "loops.air.protection": {
            "maximum_c": 80.0, "heating": None, "runaway": None, "frozen": None,
            "rising_while_off": None,
        },
    },
    "extruder": {
        "sensors.nozzle": {"conversion_s": 0.04}, "outputs.heater": {"full_share": 1.0},
        "simulation.scenario.0": {"send": "M104 S200", "extrude_mm_per_s": None},
        "simulation.scenario.1": {"send": None, "extrude_mm_per_s": 5.0},
        "simulation.plant.filament": {"node": "block", "heat_j_per_k_mm": 0.0056},
    },
    "rated": {"outputs.heater": {"full_share": 0.25}},
    "analog": {
        "sensors.nozzle": {
            "scale_v_per_k": 0.01, "offset_v": 1.0, "open_reads": "low", "oversample": 1,
            "conversion_s": 0.01, "step_k": pytest.approx(5 / 1024 / 0.01),
        },
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
    for name in path.split(".") if path else ():
        if isinstance(found, tuple) and name.isdecimal():
            found = found[int(name)]
        else:
            found = found[name] if isinstance(found, Mapping) else getattr(found, name)
    return found


def chosen(found: object, paths: Mapping[str, object]) -> dict[str, object]:
    return {path: at(found, path) for path in paths}


@pytest.mark.parametrize(
    ("spec", "path"), [(spec, path) for spec, parts in READ.items() for path in parts]
)
def test_what_a_spec_becomes(spec: str, path: str) -> None:
    expected = READ[spec][path]
    assert chosen(at(controller_of(TEXTS.get(spec, spec)), path), expected) == expected


WIRES = {"chip_select": "D2", "clock": "D3", "data_out": "D4"}


@pytest.mark.parametrize(
    ("model", "given", "expected"),
    [
        (language.Autotune, {}, {"cycles": 5, "swing_percent": 100.0, "timeout_s": 1200.0}),
        (language.Current, {"sensor": "wire", "limit": "4 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        (language.Current, {"sensor": "wire", "trip": "5 A"}, {"over_a": 5.0, "nominal_a": 4.0}),
        # A character has eleven bits after the standard.
        (language.ModbusRtu, {"kind": "modbus_rtu"}, {"stop_bits": 1, "character_bits": 11}),
        (language.ModbusRtu, {"kind": "modbus_rtu", "parity": "odd"}, {"character_bits": 11}),
        (language.ModbusRtu, {"kind": "modbus_rtu", "parity": "none"}, {"character_bits": 11}),
        (language.ModbusRtu, {"kind": "modbus_rtu", "parity": "none", "stop_bits": 1},
         {"character_bits": 10}),
        (language.Max6675, {"kind": "max6675", **WIRES},
         {"range_c": (0.0, 1023.75), "step_k": 0.25, "conversion_s": 0.22, "read_s": 0.01}),
        (language.Max31855, {"kind": "max31855", **WIRES},
         {"range_c": (-200.0, 1350.0), "step_k": 0.25, "conversion_s": 0.1, "read_s": 0.1}),
        (language.Max31855, {"kind": "max31855", "thermocouple": "T", **WIRES},
         {"range_c": (-250.0, 400.0)}),
        (language.Gcode, {"kind": "gcode", "loops": {"T0": "air"}}, {"fans": {}, "steppers": {}}),
    ],
)  # fmt: skip
def test_what_is_not_given(model: Any, given: object, expected: dict[str, object]) -> None:
    """What the models' own defaults do not say; those stand in docs/language.md."""
    assert chosen(model.model_validate(given), expected) == expected


STORED = tuple({"name": 12 * str(i), "segments": ({"hold": "1 h"},)} for i in range(5))


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({}, {"points": 10, "places": 3, "stored": (), "hold_back": language.HoldBack(),
              "after_power_loss": language.AfterPowerLoss()}),
        # As many places as are stored.
        ({"stored": STORED}, {"places": 5}), ({"stored": STORED, "places": 7}, {"places": 7}),
        ({"hold_back": "5 K"}, {"hold_back.within_k": 5.0, "hold_back.limit_s": 7200.0}),
        ({"hold_back": {"within": "5 K", "limit": "30 min"}},
         {"hold_back.within_k": 5.0, "hold_back.limit_s": 1800.0}),
        ({"hold_back": {"limit": "30 min"}}, {"hold_back.within_k": 8.0}),
        ({"hold_back": "off"}, {"hold_back": None}),
        ({"after_power_loss": "stop"},
         {"after_power_loss.resume_within_k": 0.0, "after_power_loss.otherwise": "stop"}),
    ],
)  # fmt: skip
def test_programs(keys: dict[str, object], expected: dict[str, object]) -> None:
    programs = language.Programs.model_validate({"loop": "chamber", **keys})
    assert chosen(programs, expected) == expected


IDS = """
    sensor_no_answer sensor_short sensor_crc sensor_stale sensor_reset over_temperature
    under_temperature rise_rate sensor_frozen heating_failed runaway_above runaway_below
    rising_while_off watchdog_reset brown_out settings_corrupt sensor_open sensor_range
    emergency_stop over_current current_while_off no_current master_lost program_lags
    relay_welded relay_open monitor_limit fan_stopped memory_damaged on_too_long input_open
    sensors_disagree
"""  # from code 1 on


SELF_CHECKS = {
    35: "ram_damaged", 36: "flash_damaged", 37: "clock_wrong", 38: "eeprom_worn",
    39: "sequence_broken", 40: "adc_wrong", 41: "stack_overrun", 42: "flash_unsealed",
    43: "pin_held",
}  # fmt: skip


def test_rules_keep_their_codes() -> None:
    efforts = {33: "effort_high", 34: "effort_low"}
    known = dict(enumerate(IDS.split(), start=1)) | efforts | SELF_CHECKS
    assert {code: rule.id for code, rule in RULES.items()} == known
    for code, rule in RULES.items():
        assert (rule.code, rule.display.isascii()) == (code, True)
        assert rule.display == rule.display.upper()[:12] != ""
        assert rule.meaning[-1] == rule.remedy[-1] == "."


OF_A_LOOP = (
    "commanded", "switched", "tunable", "hosted", "starts_enabled", "programmed", "must_release",
)  # fmt: skip
PLOTTER = "kind: serial_plotter, loop: air, baud: 9600"
OF_ALL = ("gcode", "modbus", "nextion")
CHANGED = {
    "the extruder, on or off": changed(
        bases()["extruder"],
        ("kind: pid, kp: 9, ki: 0.3, kd: 31, derivative_filter: 1 s, band: 10 K", "kind: on_off"),
    ),
    "the kiln, started": changed(
        bases()["programmed_kiln"], ("    period: 1 s", "    starts: enabled\n    period: 1 s")
    ),
    "the chamber, off at first": re.sub(".*starts: enabled.*\n", "", changed("chamber")),
    "the chamber and a host": changed("chamber", (PLOTTER, "kind: gcode, loops: {T0: air}")),
    "the chamber and a master": changed("chamber", (PLOTTER, "kind: modbus_rtu")),
    "the incubator and a master": changed(
        "incubator", ("{kind: serial_plotter, loop: air, baud: 9600}", "{kind: modbus_rtu}")
    ),
    "the kiln and a master": changed(
        bases()["kiln"], ("loop: chamber}", "loop: chamber, port: 1}\n  - {kind: modbus_rtu}")
    ),
}  # the master has all loops, and people switch them at the display


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("hotplate", "commanded switched"),
        ("incubator", "starts_enabled"),
        *((name, "commanded switched starts_enabled") for name in ("chamber", "oven")),
        ("the chamber, off at first", "commanded switched"),
        ("the chamber and a host", "commanded hosted starts_enabled gcode"),
        ("the chamber and a master", "commanded switched starts_enabled must_release modbus"),
        ("the incubator and a master", "commanded switched tunable must_release modbus"),
        ("extruder", "commanded tunable hosted starts_enabled gcode"),
        ("the extruder, on or off", "commanded hosted starts_enabled gcode"),
        ("feeder", "commanded tunable hosted starts_enabled gcode"),
        ("fabricator", "commanded switched must_release modbus"),
        ("dryer", "commanded switched tunable must_release modbus"),
        ("kiln", "commanded switched tunable programmed nextion"),
        ("the kiln, started", "commanded switched tunable starts_enabled programmed nextion"),
        ("the kiln and a master", "commanded switched tunable must_release modbus nextion"),
        ("kiln_uno", "commanded switched tunable programmed"),
    ],
)
def test_who_has_a_loop(name: str, expected: str) -> None:
    controller = controller_of(CHANGED.get(name, name))
    loop = next(iter(controller.loops))
    held = [fact for fact in OF_A_LOOP if getattr(facts_of(controller, loop), fact)]
    held += [fact for fact in OF_ALL if getattr(facts_of(controller), fact)]
    assert held == expected.split()


@pytest.mark.parametrize(
    ("name", "loop", "algorithm"),
    [
        ("kiln", "chamber", {"kind": "pid", "kp": 5, "ki": 0.01}),
        ("fabricator", "nozzle", {"kind": "three_position", "dead_band": "5 K"}),
    ],
)
def test_a_row_of_a_comparison_needs_nobody(name: str, loop: str, algorithm: object) -> None:
    keys = {"name": "row", "setpoint": "200 °C", "algorithm": algorithm}
    row = ComparisonRow.model_validate(keys)
    assert commands.starts_enabled(row_controller(example(name).controller, row), loop)


def test_zero_is_a_hosts_word_for_off() -> None:
    """A commanded loop may begin at 0 °C although it cannot be set so low."""
    narrow = changed(bases()["extruder"], ("minimum: 0 °C,", "minimum: 170 °C,"))
    assert load_text(narrow).controller.loops["nozzle"].setpoint.initial_c == 0.0
    host = "kind: gcode, loops: {T0: nozzle}, fans: {P0: fan}"
    with pytest.raises(SpecError):
        load_text(changed(narrow, (host, "kind: serial_plotter")))


@pytest.mark.parametrize("what", [*AMOUNTS, *GAINS, *SWITCHES, *COMMANDS])
def test_everything_a_master_can_write_can_be_written(what: str) -> None:
    written, value = {"setpoint": ("60 °C", 60.0), "manual_duty": ("12.5 %", 12.5)}.get(
        what, ("1.5", 1.5) if what in GAINS else ("true", True)
    )
    name = what if what in COMMANDS else f"air.{what}"
    event = f"{{{name}: {written}}}}}\n    - {{at: 6 s, write: {{air"
    text = changed("dryer", ("{air.setpoint: 70 °C, air", event))
    assert load_text(text).controller.simulated.scenario[0].write == (Write(name, value),)


@pytest.mark.parametrize("bits", [9, 10, 11, 12])
def test_a_ds18b20_after_its_data_sheet(bits: int) -> None:
    keys = {"kind": "ds18b20", "pin": "A1", "resolution": f"{bits} bit"}
    sensor = language.Ds18b20.model_validate(keys)
    assert sensor.conversion_s == {9: 0.09375, 10: 0.1875, 11: 0.375, 12: 0.75}[bits]
    assert shortest_period_s(sensor) == {9: 0.15, 10: 0.24, 11: 0.43, 12: 0.8}[bits]
    assert sensor.step_k == {9: 0.5, 10: 0.25, 11: 0.125, 12: 0.0625}[bits]
    assert [sensor.error_k(t) for t in (-55, -30, -10, 85, 100, 125)] == [2, 1, 0.5, 0.5, 1, 2]
