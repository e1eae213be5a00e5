"""The temperature expected from the slope (docs/control.md, "on_off" and "three_position")."""

from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single, faded, filter_share


class Lead:
    """Extrapolates the temperature along its filtered slope, if there is a lead."""

    def __init__(
        self, lead_s: float, filter_s: float, period_s: float, *, keyed: bool = False
    ) -> None:
        """Derive the constants; keyed -- the keypad sets the lead."""
        self._leads = lead_s > 0 or keyed
        self._lead_s = Single(lead_s)
        self._share = filter_share(period_s, filter_s)
        self._per_period = Single(1 / period_s)
        self.members: tuple[Member, ...] = (("rate_k_per_s", "f4"),) if self._leads else ()
        self.reset()

    def take(self, lead_s: Single) -> None:
        """Set the lead from now on."""
        self._lead_s = lead_s

    def reset(self) -> None:
        """Forget the slope."""
        self._rate = ZERO

    def expected_c(self, temperature_c: Single, last_c: Single, gap: int) -> Single:
        """Process a reading and return the temperature expected after the lead."""
        if not self._leads:
            return temperature_c
        if gap == 1:
            slope = (temperature_c - last_c) * self._per_period
            self._rate = faded(self._rate + self._share * (slope - self._rate))
        return temperature_c + self._lead_s * self._rate

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (self._rate,) if self._leads else ()
