"""Commands to a loop, by keypad or interface (docs/control.md, "Commands" and "Keys")."""

from heatwright.sim.reference.algorithms.autotune import DONE, RUNNING, STOPPED
from heatwright.sim.reference.algorithms.pid import gains_of, limits_given, may_limit
from heatwright.sim.reference.inputs import AUTOMATIC, MANUAL, TUNING, Gains, Limits, Orders
from heatwright.sim.reference.interfaces.keyed import Numbers, given
from heatwright.sim.reference.loop import Reference
from heatwright.sim.reference.numbers import FULL, ZERO, Single, clamp
from heatwright.sim.reference.programs.state import NO_ORDER
from heatwright.spec import Controller, facts_of

LARGEST_GAIN = 1e6
NO_LIMITS = (None, None, None)


class Operator:
    """The commands that the next step takes over."""

    def __init__(self, controller: Controller, name: str, reference: Reference) -> None:
        """Start with the spec's initial values."""
        loop, facts = controller.loops[name], facts_of(controller, name)
        self._reference = reference
        self._commanded = facts.commanded
        self._minimum_c = Single(loop.setpoint.minimum_c)
        self._maximum_c = Single(loop.setpoint.maximum_c)
        self.setpoint_c = Single(loop.setpoint.initial_c)
        self._mode = AUTOMATIC
        self._manual_percent = ZERO
        self.gains = gains_of(loop.algorithm) if facts.tunable else None
        self._algorithm = loop.algorithm
        self.limits = limits_given(loop.algorithm)
        highest_c = Single(loop.protection.maximum_c)
        self._highest_c = highest_c if facts.adjustable else None
        self._critical_c = self._highest_c
        self._program = NO_ORDER
        self.numbers: Numbers = given(facts.keyed_numbers)
        """The numbers that the keypad has set."""

    @property
    def orders(self) -> Orders:
        """The commands that the next step takes over."""
        return Orders(
            self._mode,
            self._manual_percent,
            self.gains,
            self.limits,
            maximum_c=self._critical_c,
            program=self._program,
            numbers=self.numbers,
        )

    @property
    def is_off(self) -> bool:
        """Whether the loop is a commanded one, and off."""
        return self._commanded and self._mode == AUTOMATIC and bool(self.setpoint_c == ZERO)

    @property
    def is_automatic(self) -> bool:
        """Whether the algorithm holds a setpoint."""
        return self._mode == AUTOMATIC and not self.is_off

    def change(self, by_k: Single) -> None:
        """Press UP or DOWN; DOWN at the lowest setpoint is off."""
        if by_k < ZERO and (self.is_off or self.setpoint_c <= self._minimum_c):
            self.key_off()
        else:
            self.set(float(clamp(self.setpoint_c + by_k, self._minimum_c, self._maximum_c)))

    def key_off(self) -> None:
        """Press the key that switches off."""
        self.set(0.0)

    def set(self, setpoint_c: float) -> bool:
        """Set the setpoint, or switch off; return whether that is allowed."""
        if not self._may(Single(setpoint_c)):
            return False
        self.setpoint_c = Single(setpoint_c)
        self._mode = AUTOMATIC
        return True

    def set_manual(self, percent: float | None) -> bool:
        """Set the manual duty, by default the present duty; return whether that is allowed."""
        wanted = self._reference.duty_percent if percent is None else Single(percent)
        if self.gains is None or self._reference.fault_code or not ZERO <= wanted <= FULL:
            return False
        self._mode = MANUAL
        self._manual_percent = wanted
        return True

    def set_gains(
        self,
        kp: float | None,
        ki: float | None,
        kd: float | None,
        *,
        limits: tuple[float | None, ...] = NO_LIMITS,
    ) -> bool:
        """Change the gains and limits that are not None; return whether that is allowed."""
        given = [gain for gain in (kp, ki, kd) if gain is not None]
        if self.gains is None or not all(0 <= gain <= LARGEST_GAIN for gain in given):
            return False
        if limits != NO_LIMITS and not self.set_limits(*limits):
            return False
        wanted = zip((kp, ki, kd), self.gains, strict=True)
        self.gains = Gains(*(old if new is None else Single(new) for new, old in wanted))
        return True

    def set_limits(
        self,
        integral_minimum: float | None,
        integral_maximum: float | None,
        output_maximum: float | None,
    ) -> bool:
        """Change the limits that are not None; return whether that is allowed."""
        if self.limits is None:
            return False
        given = zip((integral_minimum, integral_maximum, output_maximum), self.limits, strict=True)
        wanted = Limits(*(old if new is None else Single(new) for new, old in given))
        if not may_limit(self._algorithm, wanted):
            return False
        self.limits = wanted
        return True

    def set_critical(self, maximum_c: float) -> bool:
        """Set the critical temperature; return whether that is allowed."""
        wanted_c = Single(maximum_c)
        if self._highest_c is None or not self._minimum_c <= wanted_c <= self._highest_c:
            return False
        self._critical_c = wanted_c
        return True

    def tune(self, target_c: float, cycles: int | None) -> bool:
        """Start a tuning; return whether that is allowed."""
        tuner = self._reference.steering.tuner
        if tuner is None or target_c == 0 or not self._may(Single(target_c)):
            return False
        tuner.start(cycles)
        self.setpoint_c = Single(target_c)
        self._mode = TUNING
        return True

    def stop_tuning(self) -> None:
        """Stop a tuning."""
        if self._mode == TUNING:
            self._go_off()

    def acknowledge(self) -> None:
        """Acknowledge a fault; a commanded loop stays off."""
        if self._reference.fault_code:
            self._reference.acknowledge()
            if self._commanded:
                self._go_off()

    def after_step(self) -> None:
        """Take over the result of a tuning."""
        tuner = self._reference.steering.tuner
        if tuner is None or self._mode != TUNING or tuner.result in (RUNNING, STOPPED):
            return
        self._go_off()
        if tuner.result == DONE:
            self.gains = tuner.gains

    def see_fault(self) -> None:
        """React to a new fault: only the operator of a switched loop does."""

    def _may(self, setpoint_c: Single) -> bool:
        if setpoint_c == ZERO:
            return True
        inside = self._minimum_c <= setpoint_c <= self._maximum_c
        return bool(inside) and not self._reference.fault_code

    def _go_off(self) -> None:
        self._mode = AUTOMATIC
        self.setpoint_c = ZERO
