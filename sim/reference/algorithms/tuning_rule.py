"""Compute gains from the swings of a relay experiment (docs/control.md, "The rule")."""

from typing import NamedTuple

from heatwright.sim.reference.inputs import Limits
from heatwright.sim.reference.numbers import ZERO, Single, clamp, period
from heatwright.spec import Autotune, Loop, Pid

PER_LATE, PER_DEAD = Single(0.35), Single(2)
LEAST_RATIO, MOST_RATIO = Single(10), Single(40)
BELOW_HOLD, PER_HOLD = Single(12), Single(1.5)
"""For the proposed limits of the integral, %: distance below hold, and factor of hold."""
ONE, TWO, THREE, FOUR, SIX = map(Single, (1, 2, 3, 4, 6))
LEAST_LACK_PERCENT = Single(0.01)
LEAST_RISE = Single(1e-6)
"""K/s; a smaller rise is not a valid measurement."""


class Constants(NamedTuple):
    """The constants from the loop's spec."""

    period_s: Single
    swing_percent: Single
    filter_s: Single
    least_s: Single
    start_percent: Single
    band_k: Single | None
    limits_percent: tuple[Single, Single]
    """Limits of the integral."""

    @classmethod
    def of(cls, algorithm: Pid, autotune: Autotune, loop: Loop) -> "Constants":
        """Derive the constants."""
        limits = algorithm.integral
        return cls(
            period(loop),
            Single(algorithm.output.maximum_percent * autotune.swing_percent / 100),
            Single(algorithm.derivative_filter_s),
            Single(1.35 * (algorithm.derivative_filter_s + loop.period_s)),
            clamp(ZERO, Single(limits.minimum_percent), Single(limits.maximum_percent)),
            None if algorithm.band_k is None else Single(algorithm.band_k),
            (Single(limits.minimum_percent), Single(limits.maximum_percent)),
        )

    def time_s(self, steps: Single) -> Single:
        """Return how long a number of steps takes, s."""
        return steps * self.period_s

    def within(self, limits: Limits, swing_share: Single) -> "Constants":
        """Return the constants with a host's narrower limits; the limits for the proposal stay."""
        return self._replace(
            swing_percent=limits.output_maximum * swing_share,
            start_percent=clamp(ZERO, limits.integral_minimum, limits.integral_maximum),
        )


class Swings(NamedTuple):
    """The measurements: sums over all swings but the first, and the slope."""

    number: Single
    on_sum: Single
    """Time with the heater on, steps."""
    off_sum: Single
    """Time with the heater off, steps."""
    swing_sum: Single
    """Temperature when the heater went off minus that when it went on, K."""
    peak_sum: Single
    """Highest temperature minus that when the heater went off, K."""
    rise: Single
    """Slope of the temperature while the heater is on, K/s."""

    @property
    def are_measured(self) -> bool:
        """Whether these numbers are possible for a machine."""
        return bool(self.rise >= LEAST_RISE and self.on_sum > ZERO and self.off_sum > ZERO)


class Found(NamedTuple):
    """The results, in the order of the members."""

    hold_percent: Single
    lag_s: Single
    dead_s: Single
    kp: Single
    ki: Single
    kd: Single
    integral_minimum: Single
    integral_maximum: Single


def found_by(swings: Swings, constants: Constants) -> Found:
    """Compute the results from the measurements, line by line as the rule is written."""
    rise = swings.rise
    on_s = constants.time_s(swings.on_sum) / swings.number
    off_s = constants.time_s(swings.off_sum) / swings.number
    swing_k = swings.swing_sum / swings.number
    peak_k = swings.peak_sum / swings.number
    fall = rise * on_s / off_s
    both = rise + fall
    hold_percent = constants.swing_percent * on_s / (on_s + off_s)
    late_s = clamp(rise * on_s - swing_k, ZERO, TWO * rise * on_s) / both
    share = THREE / (FOUR + SIX * on_s / off_s)
    carried = rise * (ONE - share)
    dead_s = clamp(peak_k - share * rise * late_s, ZERO, carried * late_s) / carried
    lag_s = max(ZERO, late_s - dead_s)  # rounding can make it negative
    dead_s = late_s - lag_s
    quick_s = _quick(late_s, dead_s, constants)
    gain = constants.swing_percent / (both * quick_s)
    kd = gain * lag_s
    slow_s = _ratio(rise, hold_percent, gain, kd, constants) * quick_s
    return Found(
        hold_percent,
        lag_s,
        dead_s,
        gain + kd / slow_s,
        gain / slow_s,
        kd,
        clamp(hold_percent - BELOW_HOLD, *constants.limits_percent),
        clamp(hold_percent * PER_HOLD, *constants.limits_percent),
    )


def _quick(late_s: Single, dead_s: Single, constants: Constants) -> Single:
    quick_s = max(PER_LATE * late_s, PER_DEAD * dead_s + constants.filter_s)
    return max(quick_s, constants.least_s)


def _ratio(
    rise: Single, hold_percent: Single, gain: Single, kd: Single, constants: Constants
) -> Single:
    """Return the integral time, in time constants of the closed loop."""
    way = constants.swing_percent - constants.start_percent + kd * rise
    if constants.band_k is not None:
        way = min(way, gain * constants.band_k)
    lack = hold_percent - constants.start_percent
    return clamp(way / lack, LEAST_RATIO, MOST_RATIO) if lack > LEAST_LACK_PERCENT else MOST_RATIO
