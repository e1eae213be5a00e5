"""Pins: they must exist, be free, and have the function that is needed."""

from collections.abc import Iterator

from heatwright.spec.board.uses import SERIAL_PORT, PinUse, pin_uses, wired_pins
from heatwright.spec.boards import Pin
from heatwright.spec.checks.finding import Finding, Findings, loop_heaters
from heatwright.spec.controller import Controller
from heatwright.spec.loading.suggest import advice, listed
from heatwright.spec.outputs import Switch
from heatwright.spec.problems import Path, dotted

_BOARD: Path = ("controller", "board")


def pins_exist(controller: Controller) -> Findings:
    """Find names that are no pin of the board."""
    board = controller.board
    for path, pin_name in _named(controller):
        if pin_name not in board.pins:
            yield Finding(
                path,
                f"{board.name} has no pin {pin_name}",
                advice(pin_name, tuple(board.pins)),
                (_BOARD,),
            )


def _named(controller: Controller) -> Iterator[tuple[Path, str]]:
    """List all pins that the file names, with their paths."""
    for path, pin_name, _ in wired_pins(controller):
        yield path, pin_name
    for index, interface in enumerate(controller.interfaces):
        for keys, pin_name, _ in interface.named_pins:
            yield ("interfaces", index, *keys), pin_name


def pins_can_be_switched(controller: Controller) -> Findings:
    """Find digital parts on pins that lead only to the ADC."""
    board = controller.board
    for use in pin_uses(controller):
        if not use.pin.digital and not is_analog(controller, use.path):
            yield Finding(
                use.path,
                f"{use.pin.name} of {board.name} leads only to the ADC and cannot be switched or "
                "read",
                "Use a digital pin",
                (_BOARD,),
            )


def analog_pins(controller: Controller) -> Findings:
    """Find sensors that need the ADC on pins that do not lead to it."""
    board = controller.board
    for use in pin_uses(controller):
        if is_analog(controller, use.path) and use.pin.adc is None:
            able = {pin.name: None for pin in board.pins.values() if pin.adc is not None}
            yield Finding(
                use.path,
                f"{use.pin.label} does not lead to the ADC",
                f"Use {listed(tuple(able))}",
                (_BOARD, use.path[:2]),
            )


def is_analog(controller: Controller, path: Path) -> bool:
    """Return whether an entry belongs to a sensor on the ADC."""
    return path[0] == "sensors" and path[1] in controller.adc_sensors


def pins_used_once(controller: Controller) -> Findings:
    """Find pins that two parts of the file would use."""
    first: dict[Pin, PinUse] = {}
    reported = set()
    for use in pin_uses(controller):
        other = first.setdefault(use.pin, use)
        if SERIAL_PORT == use.purpose == other.purpose:
            continue  # ports.one_interface_per_port reports it better
        # A shield and a serial port have several pins; one problem for each pair is enough.
        if other is not use and (use.path, other.path) not in reported:
            reported.add((use.path, other.path))
            yield Finding(
                use.path,
                f"{use.pin.label}{_what_for(use)} is already used by {dotted(other.path[:2])}"
                f"{_what_for(other)}",
                "Use another pin",
                (other.path,),
            )


def _what_for(use: PinUse) -> str:
    return f" (for {use.purpose})" if use.purpose else ""


def shields_fit(controller: Controller) -> Findings:
    """Find shields on boards that they do not fit."""
    board = controller.board
    for index, interface in enumerate(controller.interfaces):
        if interface.shield is not None and not board.shield:
            yield Finding(
                ("interfaces", index, "kind"),
                f"an Uno's shield does not fit {board.name}",
                "Use uno, mega2560 or leonardo, or delete this interface",
                (_BOARD,),
            )


def heater_pins_stay_off(controller: Controller) -> Findings:
    """Refuse heaters and safety relays on pins that are driven before the program runs.

    A bootloader flashes the LED and uses the serial port at each reset; on a bare chip the
    programmer clocks SCK and MOSI while the chip is held in reset.
    """
    board = controller.board
    for name, output, what, by in _kept_off(controller):
        pin = board.pins.get(output.pin)
        if pin is None:
            continue
        why = ""
        if pin.bootloader:
            why = "the bootloader drives it at each reset"
        elif board.bootloader_bytes == 0 and pin.spi in {"sck", "mosi"}:
            why = "the programmer drives it while it writes the chip"
        if why:
            yield Finding(
                ("outputs", name, "pin"),
                f"{pin.label} would switch the {what} before the program runs: {why}",
                f"Use another pin for a {what}",
                (_BOARD, by),
            )


def _kept_off(controller: Controller) -> Iterator[tuple[str, Switch, str, Path]]:
    """List outputs that must be off until the program runs: name, output, its role, path of use."""
    for name, loop, heater in loop_heaters(controller):
        yield loop.heater, heater, "heater", ("loops", name, "heater")
    relay = controller.switches.get(controller.safety.relay or "")
    if controller.safety.relay is not None and relay is not None:
        yield controller.safety.relay, relay, "safety relay", ("safety", "relay")


def jtag_pins_are_free(controller: Controller) -> Findings:
    """Refuse the pins of the JTAG port on a bare chip: a program cannot drive them."""
    board = controller.board
    if board.bootloader_bytes:
        return
    for use in pin_uses(controller):
        if use.pin.port_name in board.jtag_pins:
            yield Finding(
                use.path,
                f"{use.pin.label} belongs to the JTAG port, which a new chip has enabled, so the "
                "program could not drive it",
                "Use another pin",
                (_BOARD,),
            )
