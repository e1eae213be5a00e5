"""The protections of a loop (docs/control.md, "Protections")."""

from collections.abc import Iterator

from heatwright.sim.reference.numbers import Member, Single, Value, steps
from heatwright.sim.reference.protection.rules import AgreementRule, GuardRule, Look, rules_of
from heatwright.sim.reference.sensors.reading import MOST_MISSING, RAW_WIDTH
from heatwright.spec import Loop

OVER_TEMPERATURE = 6
UNDER_TEMPERATURE = 7
RISE_RATE = 8
ON_TOO_LONG = 30


class Guard:
    """Applies the rules of a loop, and returns the code of the first one that trips."""

    def __init__(self, loop: Loop, raw_width: str = RAW_WIDTH) -> None:
        """Derive the limits; raw_width -- width of the sensor's raw numbers."""
        protection = loop.protection
        self._stale_steps = min(MOST_MISSING, steps(protection.stale_after_s, loop))
        self._maximum_c = Single(protection.maximum_c)
        self._minimum_c = Single(protection.minimum_c)
        self._rise_per_step = Single(loop.rise_per_period_k)
        self._rules: tuple[GuardRule, ...] = rules_of(loop, raw_width)
        agreement = protection.agreement
        self._agreement = None if agreement is None else AgreementRule(agreement, loop)
        self._is_adjustable = protection.maximum_adjustable
        on_s = protection.on_for_at_most_s
        self._most_on_steps = None if on_s is None else steps(on_s, loop)
        self._on_steps = 0
        self.fresh = 1
        self.members: tuple[Member, ...] = (
            *(member for rule in self._rules for member in rule.members),
            *(self._agreement.members if self._agreement else ()),
            ("fresh", "u1"),
            *((("maximum_c", "f4"),) if self._is_adjustable else ()),
            *((("on_steps", "u4"),) if on_s is not None else ()),
        )

    def reset(self) -> None:
        """Start again, after an acknowledgement."""
        for rule in self._rules:
            rule.reset()
        if self._agreement:
            self._agreement.reset()
        self.fresh = 1
        self._on_steps = 0

    def take(self, maximum_c: Single | None) -> None:
        """Take over the operator's critical temperature, if there is one."""
        if not self._is_adjustable:
            return
        if maximum_c is None:
            raise ValueError("The loop needs its critical temperature")
        self._maximum_c = maximum_c

    def count(self, *, on: bool) -> int:
        """Return 30 if a loop has been on for too long; on -- whether it is on without a fault."""
        if self._most_on_steps is None:
            return 0
        self._on_steps = self._on_steps + 1 if on else 0
        return ON_TOO_LONG if self._on_steps >= self._most_on_steps else 0

    def feel(self, duty_percent: Single) -> None:
        """Take over the duty of the step before, at every step that is checked."""
        for rule in self._rules:
            rule.feel(duty_percent)

    def without_reading(self, status: int, missing: int) -> int:
        """Return the fault code after a step without a reading, 0 for none."""
        return status if missing >= self._stale_steps else 0

    def with_reading(self, look: Look) -> int:
        """Return the fault code after a step with a reading, 0 for none."""
        code = self._reading(look)
        if code:
            return code
        if self._agreement is not None:
            code = self._agreement.check(look)
            if code:
                return code
        if self.fresh:
            for rule in self._rules:
                rule.start(look)
            self.fresh = 0
        for rule in self._rules:
            code = rule.check(look)
            if code:
                return code
        return 0

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        found: tuple[Value, ...] = ()
        for rule in self._rules:
            found += rule.values()
        return (
            *found,
            *(self._agreement.values() if self._agreement else ()),
            self.fresh,
            *((self._maximum_c,) if self._is_adjustable else ()),
            *((self._on_steps,) if self._most_on_steps is not None else ()),
        )

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members`."""
        for rule in self._rules:
            rule.resume(values)
        if self._agreement:
            self._agreement.resume(values)
        self.fresh = next(values)
        if self._is_adjustable:
            self._maximum_c = next(values)
        if self._most_on_steps is not None:
            self._on_steps = next(values)

    def _reading(self, look: Look) -> int:
        if look.temperature_c >= self._maximum_c:
            return OVER_TEMPERATURE
        if look.temperature_c <= self._minimum_c:
            return UNDER_TEMPERATURE
        if abs(look.temperature_c - look.last_c) > self._rise_per_step * Single(look.gap):
            return RISE_RATE
        return 0
