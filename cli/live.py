"""A simulated board at a serial port of this computer, for the user's own host."""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import TYPE_CHECKING

import click

from heatwright.cli.ends import Refused
from heatwright.cli.talk import talk

if TYPE_CHECKING:
    from heatwright.spec import Spec


def serve(spec: Spec, *, speed: float, until_s: float | None, as_json: bool) -> None:
    """Build the firmware and run it in real time until Ctrl-C, or until `until_s`.

    speed -- board time divided by real time.
    """
    from heatwright.spec import facts_of  # noqa: PLC0415

    controller = spec.controller
    facts = facts_of(controller)
    listener = facts.gcode or facts.modbus or facts.nextion or facts.log
    if listener is None:
        raise Refused(
            "No interface of this spec listens to a serial port: add one of kind gcode, "
            "modbus_rtu, nextion or serial_log."
        )
    if controller.simulation is None:
        raise Refused("There is no machine to run against: the spec has no `simulation`.")
    from heatwright.cli.firmware import build_firmware  # noqa: PLC0415
    from heatwright.sim.device import AvrDevice  # noqa: PLC0415 - needs the native part
    from heatwright.sim.interfaces.modbus_rtu import format_of  # noqa: PLC0415
    from heatwright.sim.lines.serial_port import SerialPort  # noqa: PLC0415
    from heatwright.sim.live import Clock, run  # noqa: PLC0415

    with talk() as shown:
        built = build_firmware(spec, shown.begin("Building the firmware"))
    device, line = AvrDevice(controller, built.elf), listener.line
    uart = controller.board.uarts[line.port].number
    port = SerialPort(device, line.baud, format_of(line), uart=uart)
    with port, suppress(KeyboardInterrupt):
        _announce(port.name, line.baud, speed, as_json)
        run(controller, device, port, Clock(speed), until_s=until_s)


def _announce(port: str, baud: int, speed: float, as_json: bool) -> None:
    if as_json:
        from heatwright.cli.options import print_json  # noqa: PLC0415

        print_json(port=port, baud=baud, speed=speed)
    else:
        click.echo(f"{port}: {baud} baud, {speed:g} times real time. Ctrl-C ends it.")
    sys.stdout.flush()
