"""Rules that check the temperature over many steps."""

from abc import ABC, abstractmethod
from typing import NamedTuple

from heatwright.sim.reference.numbers import LARGEST_COUNT, ZERO, Kept, Single, filter_share, steps
from heatwright.spec import Frozen, Heating, Loop, RisingWhileOff, Runaway
from heatwright.spec.loops import Agreement, Effort

FROZEN = 9
HEATING_FAILED = 10
RUNAWAY_ABOVE = 11
RUNAWAY_BELOW = 12
RISING_WHILE_OFF = 13
SENSORS_DISAGREE = 32
EFFORT_HIGH = 33
EFFORT_LOW = 34

NOWHERE_C = Single(-1000)
"""A start value that differs from every reading."""
FLOOR = Single(1e-12)
"""Added to a filtered power, %, so that avr-libc's products stay equal to IEEE 754's."""

ABOVE_ARMED = 1
BELOW_ARMED = 2


class Look(NamedTuple):
    """The inputs of the rules at a step with a reading."""

    temperature_c: Single
    last_c: Single
    """The reading before; the present one if there was none."""
    gap: int
    """Periods since the reading before."""
    raw: int
    setpoint_c: Single
    duty_percent: Single
    """The duty of the step before."""
    asked_percent: Single
    """The duty of the last step with a reading."""
    full_percent: Single
    """The highest duty of the loop in its present mode."""
    bandless: bool = False
    """Whether no band applies: the loop is off, in manual mode, or heats up for a tuning."""
    by_hand: bool = False
    """Whether the operator sets the duty."""
    also_c: Single = ZERO
    """The reading of the second sensor, if there is one."""
    moved: bool = False
    """Whether a program has changed the setpoint, and the band with it."""
    cooled: bool = False
    """Whether the cooler has been on since the step before."""


class GuardRule(Kept, ABC):
    """One rule with its own state, and a count of steps."""

    _steps = 0

    def reset(self) -> None:
        """Clear the counter."""
        self._steps = 0

    def start(self, look: Look) -> None:
        """Store the first reading since the reset, if the rule compares with it."""

    def feel(self, duty_percent: Single) -> None:
        """Take over the duty of the step before, with or without a reading, if it is used."""

    @abstractmethod
    def check(self, look: Look) -> int:
        """Return the code of the fault, 0 for none."""


def rules_of(loop: Loop, raw_width: str) -> tuple[GuardRule, ...]:
    """Return the loop's rules in the order in which they are checked."""
    protection = loop.protection
    rules: list[GuardRule] = []
    if protection.runaway is not None:
        rules.append(RunawayRule(protection.runaway, loop))
    if protection.heating is not None:
        rules.append(HeatingRule(protection.heating, loop))
    if protection.frozen is not None:
        rules.append(FrozenRule(protection.frozen, loop, raw_width))
    if protection.rising_while_off is not None:
        rules.append(RisingRule(protection.rising_while_off, loop))
    if protection.effort is not None:
        rules.append(EffortRule(protection.effort, loop))
    return tuple(rules)


def counted(count: int) -> int:
    """Return the count plus one, at most the maximum of a 16-bit counter."""
    return min(count + 1, LARGEST_COUNT)


class AgreementRule(GuardRule):
    """32: the loop's sensor and the second one have been apart for too long."""

    def __init__(self, agreement: Agreement, loop: Loop) -> None:
        self.keep(("apart_steps", "u2", "_steps"))
        self._within_k = Single(agreement.within_k)
        self._limit = steps(agreement.for_s, loop)

    def check(self, look: Look) -> int:
        """Return 32 after too many steps apart."""
        if abs(look.temperature_c - look.also_c) <= self._within_k:
            self._steps = 0
        else:
            self._steps = counted(self._steps)
        return SENSORS_DISAGREE if self._steps >= self._limit else 0


class RunawayRule(GuardRule):
    """11 and 12: the temperature left the band around the setpoint after having been in it."""

    def __init__(self, runaway: Runaway, loop: Loop) -> None:
        self.keep(
            ("runaway_steps", "u2", "_steps"),
            ("in_band", "u1", "_in_band"),
            ("setpoint_last_c", "f4", "_setpoint_last_c"),
        )
        self._above = Single(runaway.above_k)
        self._below = None if runaway.below_k is None else Single(runaway.below_k)
        self._limit = steps(runaway.for_s, loop)
        self._setpoint_last_c = ZERO
        self.reset()

    def reset(self) -> None:
        """Clear the counter and disarm."""
        super().reset()
        self._in_band = 0

    def start(self, look: Look) -> None:
        """Treat the first setpoint as a changed one."""
        self.reset()
        self._setpoint_last_c = look.setpoint_c

    def check(self, look: Look) -> int:
        """Return 11 or 12 after too long outside the band."""
        if look.setpoint_c != self._setpoint_last_c:
            if not look.moved:
                self.reset()
            self._setpoint_last_c = look.setpoint_c
        if look.bandless:
            self.reset()
            return 0
        above = self._is_above(look)
        below = self._is_below(look)
        self._steps = counted(self._steps) if above or below else 0
        if self._steps < self._limit:
            return 0
        return RUNAWAY_ABOVE if above else RUNAWAY_BELOW

    def _is_above(self, look: Look) -> bool:
        if look.temperature_c <= look.setpoint_c + self._above:
            self._in_band |= ABOVE_ARMED
            return False
        return bool(self._in_band & ABOVE_ARMED)

    def _is_below(self, look: Look) -> bool:
        if self._below is None:
            return False
        if look.temperature_c >= look.setpoint_c - self._below:
            self._in_band |= BELOW_ARMED
            return False
        return bool(self._in_band & BELOW_ARMED)


class HeatingRule(GuardRule):
    """10: full power for a long time did not raise the temperature."""

    def __init__(self, heating: Heating, loop: Loop) -> None:
        self.keep(("heating_steps", "u2", "_steps"), ("heating_from_c", "f4", "_from_c"))
        self._rise = Single(heating.rise_k)
        self._limit = steps(heating.within_s, loop)
        self._from_c = ZERO

    def start(self, look: Look) -> None:
        """Compare with the present temperature from now on."""
        self._from_c = look.temperature_c

    def check(self, look: Look) -> int:
        """Return 10 after too many steps at full power without the rise."""
        if (
            look.asked_percent < look.full_percent
            or look.temperature_c >= self._from_c + self._rise
        ):
            self._steps = 0
            self._from_c = look.temperature_c
            return 0
        self._steps = counted(self._steps)
        return HEATING_FAILED if self._steps >= self._limit else 0


class FrozenRule(GuardRule):
    """9: the reading does not change although the duty is more than holding needs.

    Only below the setpoint, or at a manual duty.
    """

    def __init__(self, frozen: Frozen, loop: Loop, raw_width: str) -> None:
        self.keep(("frozen_steps", "u2", "_steps"), ("frozen_raw", raw_width, "_raw"))
        self._limit = steps(frozen.for_s, loop)
        self._holding_percent = Single(frozen.holding_percent)
        self._raw = 0

    def start(self, look: Look) -> None:
        """Compare with the present code from now on."""
        self._raw = look.raw

    def check(self, look: Look) -> int:
        """Return 9 after too many equal codes."""
        if (
            look.raw != self._raw
            or look.asked_percent == ZERO
            or (not look.by_hand and look.temperature_c >= look.setpoint_c)
        ):
            self._steps = 0
            self._raw = look.raw
            return 0
        if look.asked_percent > self._holding_percent:
            self._steps = counted(self._steps)
        return FROZEN if self._steps >= self._limit else 0


class RisingRule(GuardRule):
    """13: the temperature rises although the heater is off, long after it went off."""

    def __init__(self, rising: RisingWhileOff, loop: Loop) -> None:
        self.keep(("off_steps", "u2", "_steps"), ("off_lowest_c", "f4", "_lowest_c"))
        self._rise = Single(rising.rise_k)
        self._settle = steps(rising.settle_s, loop)
        self._lowest_c = ZERO

    def start(self, look: Look) -> None:
        """Begin with the present temperature as the lowest."""
        self._lowest_c = look.temperature_c

    def check(self, look: Look) -> int:
        """Return 13 once the temperature is too far above its lowest since the heater went off."""
        if look.duty_percent > ZERO:
            self._steps = 0
        elif self._steps < self._settle:
            self._steps += 1
            self._lowest_c = look.temperature_c
        else:
            self._lowest_c = min(self._lowest_c, look.temperature_c)
            if look.temperature_c >= self._lowest_c + self._rise:
                return RISING_WHILE_OFF
        return 0


class EffortRule(GuardRule):
    """33 and 34: at a steady reading, the power is higher or lower than on a healthy machine."""

    def __init__(self, effort: Effort, loop: Loop) -> None:
        self.keep(
            ("effort_percent", "f4", "_percent"),
            ("effort_from_c", "f4", "_from_c"),
            ("effort_steps", "u2", "_steps"),
        )
        band = effort.band
        self._share = filter_share(loop.period_s, band.filter_s)
        self._move = Single(band.move_k)
        self._lines = tuple(tuple(map(Single, line)) for line in band.lines)
        self._limit = steps(effort.for_s, loop)
        self._percent = ZERO
        self._steps = 0
        self.reset()

    def reset(self) -> None:
        """Start again: the next reading counts as one that has moved."""
        self._from_c = NOWHERE_C

    def feel(self, duty_percent: Single) -> None:
        """Filter the power."""
        added = self._share * (duty_percent - self._percent) + FLOOR
        self._percent = self._percent + added

    def check(self, look: Look) -> int:
        """Return 33 or 34 after too many steps with a power outside the band."""
        temperature_c = look.temperature_c
        _, high, high_per_k, low, low_per_k = self._lines[0]
        for line in self._lines[1:]:
            if line[0] <= temperature_c:
                _, high, high_per_k, low, low_per_k = line
        limit = high_per_k * temperature_c + high
        code = EFFORT_HIGH
        if self._percent <= limit:
            limit = low_per_k * temperature_c + low
            code = 0 if self._percent >= limit else EFFORT_LOW
        if look.cooled:
            code = 0
        moved_k = temperature_c - self._from_c
        if code:
            if moved_k < self._move and moved_k > -self._move:
                self._steps = counted(self._steps)
                return code if self._steps >= self._limit else 0
            self._percent = limit
        self._from_c = temperature_c
        self._steps = 0
        return 0
