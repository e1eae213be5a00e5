"""Serial ports: they must exist, serve one interface each, and be able to make its baud rate."""

from heatwright.spec.board.uart import BAUD_TOLERANCE, baud_setting
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.loading.suggest import listed
from heatwright.spec.quantity import about, hertz, number


def ports_exist(controller: Controller) -> Findings:
    """Find serial ports that the board does not have."""
    board = controller.board
    for index, interface in enumerate(controller.interfaces):
        line, last = interface.line, len(board.uarts) - 1
        if line is not None and line.port > last:
            yield Finding(
                ("interfaces", index, "port"),
                f"{board.name} has no serial port {line.port}",
                f"Use 0 to {last}" if last else "Use 0, the only one",
                (("controller", "board"),),
            )


def one_interface_per_port(controller: Controller) -> Findings:
    """Find interfaces that would use the same serial port."""
    first: dict[int, int] = {}
    for index, interface in enumerate(controller.interfaces):
        if interface.line is None:
            continue
        port = interface.line.port
        other = first.setdefault(port, index)
        called = f"serial port {port}" if len(controller.board.uarts) > 1 else "the serial port"
        if other != index:
            yield Finding(
                ("interfaces", index, "kind"),
                f"interfaces[{other}] already uses {called}",
                _remedy(controller, set(first)),
                (("interfaces", other),),
            )


def _remedy(controller: Controller, taken: set[int]) -> str:
    """Offer a free port, if one of the interfaces can use another port."""
    free = [str(port) for port in range(len(controller.board.uarts)) if port not in taken]
    movable = any(each.line is not None and each.line.can_move for each in controller.interfaces)
    if not free or not movable:
        return "Keep one of them"
    return f"Write port: {listed(free)} at the nextion or serial_log, or keep one of them"


def baud_can_be_made(controller: Controller) -> Findings:
    """Find baud rates that the chip cannot make from its clock."""
    clock_hz = controller.board.clock_hz
    for index, interface in enumerate(controller.interfaces):
        line = interface.line
        if line is None:
            continue
        setting = baud_setting(clock_hz, line.baud)
        if abs(setting.error) > BAUD_TOLERANCE:
            able = [
                str(baud)
                for baud in line.usual_bauds
                if abs(baud_setting(clock_hz, baud).error) <= BAUD_TOLERANCE
            ]
            yield Finding(
                ("interfaces", index, "baud"),
                f"{line.baud} baud cannot be made from {hertz(clock_hz)}: the "
                f"nearest is {about(setting.baud)}, {about(100 * abs(setting.error))} % off, "
                f"and at most {number(100 * BAUD_TOLERANCE)} % are allowed",
                f"Use {listed(able)}",
                (("controller",),),
            )
