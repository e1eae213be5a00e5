"""Contacts at the machine's inputs: a door's, an emergency stop's, a thermal cut-out's."""

from heatwright.sim.avr import Avr
from heatwright.spec import Controller


class Contact:
    """A contact to ground, normally closed; its state survives a loss of power."""

    def __init__(self, name: str) -> None:
        """Create a closed contact, not yet wired."""
        self.name = name
        self.is_open = False
        self._avr: Avr | None = None
        self._pin = ""

    def power_on(self, avr: Avr, controller: Controller) -> None:
        """Connect the contact to a processor that has just been powered on."""
        self._avr = avr
        self._pin = controller.board.pins[controller.safety.inputs[self.name].pin].port_name
        self.move(is_open=self.is_open)

    def move(self, *, is_open: bool) -> None:
        """Open or close the contact; a broken wire is an open contact."""
        self.is_open = is_open
        assert self._avr is not None  # noqa: S101 - the device wires it at power-on
        self._avr.pins.drive(self._pin, None if is_open else "low")


def contacts_of(controller: Controller) -> dict[str, Contact]:
    """Create the contacts at the inputs, by their names; not yet wired."""
    return {name: Contact(name) for name in controller.safety.inputs}
