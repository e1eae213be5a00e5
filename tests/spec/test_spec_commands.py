"""Who sets a loop, switches it and tunes it, and whether it runs after the start."""

import pytest
from rig.bad_specs import bases
from rig.specs import changed, controller_of, example

from heatwright.spec import ComparisonRow, SpecError, Write, commands, load_text, row_controller
from heatwright.spec.uses import pin_uses, uart_of
from heatwright.spec.writes import AMOUNTS, COMMANDS, GAINS, SWITCHES

ON_OFF = "{kind: on_off}"
OF_A_LOOP = ("commanded", "switched", "tunable", "zero_is_off", "starts_enabled", "programmed")
OF_ALL = ("must_release", "gcode_of", "modbus_of", "nextion_of")
CHANGED = {
    "the extruder, on or off": changed(
        bases()["extruder"],
        ("{kind: pid, kp: 9, ki: 0.3, kd: 31, derivative_filter: 1 s, band: 10 K}", ON_OFF),
    ),
    "the kiln, started": changed(
        bases()["programmed_kiln"], ("    period: 1 s", "    starts: enabled\n    period: 1 s")
    ),
    "the kiln and a master": changed(
        bases()["kiln"], ("loop: chamber}", "loop: chamber, port: 1}\n  - {kind: modbus_rtu}")
    ),
}
"""The master has all loops, and people switch them at the display."""


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("chamber", "starts_enabled"),
        ("oven", "starts_enabled"),
        ("extruder", "commanded tunable zero_is_off starts_enabled gcode_of"),
        ("the extruder, on or off", "commanded zero_is_off starts_enabled gcode_of"),
        ("feeder", "commanded tunable zero_is_off starts_enabled gcode_of"),
        ("fabricator", "commanded switched must_release modbus_of"),
        ("dryer", "commanded switched tunable must_release modbus_of"),
        ("kiln", "commanded switched tunable programmed nextion_of"),
        ("the kiln, started", "commanded switched tunable starts_enabled programmed nextion_of"),
        ("the kiln and a master", "commanded switched tunable must_release modbus_of nextion_of"),
        ("kiln_uno", "commanded switched tunable programmed"),
    ],
)
def test_who_has_a_loop(name: str, expected: str) -> None:
    controller = controller_of(CHANGED.get(name, name))
    loop = next(iter(controller.loops))
    held = [name for name in OF_A_LOOP if getattr(commands, name)(controller, loop)]
    held += [name for name in OF_ALL if getattr(commands, name)(controller)]
    assert held == expected.split()


def test_what_is_no_loop_is_nobodys() -> None:
    kiln = example("kiln").controller
    assert not commands.programmed(kiln, "lid")
    assert not commands.switched(kiln, "lid")


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
    new = f"write: {{{name}: {written}}}"
    text = changed("dryer", ("write: {air.setpoint: 70 °C, air.enabled: true}", new))
    simulation = load_text(text).controller.simulation
    assert simulation is not None
    assert simulation.scenario[0].write == (Write(name, value),)


def test_interfaces_have_their_ports() -> None:
    kiln = example("kiln").controller
    ports = [uart_of(kiln.board, interface) for interface in kiln.interfaces]
    assert [port and port.number for port in ports] == [0, 1]
    pins = {use.pin.port_name: use.path[1] for use in pin_uses(kiln) if "port" in use.purpose}
    assert pins == {"PE0": 0, "PE1": 0, "PD2": 1, "PD3": 1}
