"""The temperature that a slope promises (docs/control.md, "on_off" and "three_position")."""

from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single, faded, filter_share


class Lead:
    """A look ahead along the slope, which is smoothed; without a lead nothing is looked ahead."""

    def __init__(
        self, lead_s: float, filter_s: float, period_s: float, *, keyed: bool = False
    ) -> None:
        """Derive the constants; keyed -- keys set the lead."""
        self._leads = lead_s > 0 or keyed
        self._lead_s = Single(lead_s)
        self._share = filter_share(period_s, filter_s)
        self._per_period = Single(1 / period_s)
        self.members: tuple[Member, ...] = (("rate_k_per_s", "f4"),) if self._leads else ()
        self.reset()

    def take(self, lead_s: Single) -> None:
        """Look so far ahead from now on."""
        self._lead_s = lead_s

    def reset(self) -> None:
        """Forget the slope."""
        self._rate = ZERO

    def expected_c(self, temperature_c: Single, last_c: Single, gap: int) -> Single:
        """Take in a reading and return the temperature expected a lead from now."""
        if not self._leads:
            return temperature_c
        if gap == 1:
            slope = (temperature_c - last_c) * self._per_period
            self._rate = faded(self._rate + self._share * (slope - self._rate))
        return temperature_c + self._lead_s * self._rate

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (self._rate,) if self._leads else ()
