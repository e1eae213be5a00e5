"""Commands to a switched loop (docs/control.md, "Switched loops")."""

from heatwright.sim.reference.inputs import AUTOMATIC, MANUAL, TUNING, Orders
from heatwright.sim.reference.interfaces.operator import Operator
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.spec import Controller, facts_of


class SwitchedOperator(Operator):
    """The commands to a loop that has a switch beside its setpoint."""

    def __init__(self, controller: Controller, name: str, reference: Reference) -> None:
        """Start with the spec's initial values."""
        super().__init__(controller, name, reference)
        facts = facts_of(controller, name)
        self._enabled = int(facts.starts_enabled)
        self._was_on = self._off_is_due = False
        self._must_release = facts.must_release
        self._released = False
        self._had_fault = False

    @property
    def orders(self) -> Orders:
        """The commands that the next step takes over: off for one step if it was switched off."""
        enabled = self._enabled and not self._off_is_due
        return super().orders._replace(enabled=int(enabled))

    @property
    def is_off(self) -> bool:
        """Whether the loop is switched off."""
        return not self._enabled

    def change(self, by_k: Single) -> None:
        """Press UP or DOWN; if the loop is off, UP only switches it on."""
        if not self.is_off:
            super().change(by_k)
        elif by_k > ZERO:
            self.switch(on=True)

    def key_off(self) -> None:
        """Press the key that switches off; this does not allow a master to switch on again."""
        self._go_off()

    def touch_on(self) -> bool:
        """Switch on at a display; a person need not wait until a master commands off."""
        if self._must_release and self.is_off and not self._reference.fault_code:
            self.disable()
        return self.enable()

    def touch_off(self) -> None:
        """Switch off at a display; this does not allow a master to switch on again."""
        if self._must_release:
            self._go_off()
        else:
            self.disable()

    def set(self, setpoint_c: float) -> bool:
        """Set the setpoint for when the loop is on; return whether that is allowed."""
        wanted_c = Single(setpoint_c)
        inside = self._minimum_c <= wanted_c <= self._maximum_c
        if not inside or (self._mode == TUNING and wanted_c != self.setpoint_c):
            return False
        self.setpoint_c = wanted_c
        return True

    def enable(self) -> bool:
        """Switch on; return whether that is allowed."""
        free = self._enabled or self._released or not self._must_release
        if self._reference.fault_code or not free:
            return False
        self._enabled = 1
        return True

    def disable(self) -> None:
        """Switch off, and allow switching on again."""
        self._go_off()
        self._released = True

    def switch(self, *, on: bool) -> None:
        """Switch as a person does: first off and then on, if that is needed."""
        if not on:
            self.disable()
        elif not self.enable():
            self.disable()
            self.enable()

    def set_manual_percent(self, percent: float) -> bool:
        """Set the duty of manual mode; return whether that is allowed."""
        if self.gains is None or not ZERO <= Single(percent) <= FULL:
            return False
        self._manual_percent = Single(percent)
        return True

    def set_manual(self, percent: float | None) -> bool:
        """Set the manual duty, by default the present duty; return whether that is allowed."""
        return not self.is_off and super().set_manual(percent)

    def steer_by_hand(self, *, on: bool) -> None:
        """Use the manual duty that was set before, if allowed, or automatic control."""
        if on:
            self.set_manual(float(self._manual_percent))
        elif self._mode == MANUAL:
            self._mode = AUTOMATIC

    def switch_tuning(self, *, on: bool) -> None:
        """Start a tuning at the setpoint, if allowed, or stop it."""
        if on:
            self.tune(float(self.setpoint_c), None)
        else:
            self.stop_tuning()

    def tune(self, target_c: float, cycles: int | None) -> bool:
        """Start a tuning; return whether that is allowed."""
        tuner = self._reference.steering.tuner
        if tuner is None or self.is_off or self._reference.fault_code or not self.set(target_c):
            return False
        tuner.start(cycles)
        self._mode = TUNING
        return True

    def acknowledge(self) -> None:
        """Acknowledge a fault: the loop is then off; whether it may be switched on is unchanged."""
        released = self._released
        super().acknowledge()
        self._released = released
        self._had_fault = False

    def after_step(self) -> None:
        """Take over the result of a tuning, and react to a new fault."""
        self._was_on = bool(self.orders.enabled)
        self._off_is_due = False
        super().after_step()
        self.see_fault()

    def see_fault(self) -> None:
        """Require an OFF before the next ON after a new fault of any loop."""
        has_fault = bool(self._reference.fault_code)
        if has_fault and not self._had_fault:
            self._released = False
        self._had_fault = has_fault

    def _go_off(self) -> None:
        self._mode = AUTOMATIC
        self._enabled = 0
        self._off_is_due = self._was_on
        self._released = False
