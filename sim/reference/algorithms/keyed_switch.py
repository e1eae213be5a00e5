"""Shared by the switching algorithms: lead and hysteresis, which the keypad may set.

See docs/control.md, "on_off" and "three_position".
"""

from collections.abc import Iterator

from heatwright.sim.reference.interfaces.keyed import Numbers
from heatwright.sim.reference.numbers import ZERO, Kept, Member, Single, Value, faded, filter_share
from heatwright.spec import OnOff, ThreePosition


class Lead(Kept):
    """Extrapolates the temperature along its filtered slope, if there is a lead."""

    def __init__(
        self, lead_s: float, filter_s: float, period_s: float, *, keyed: bool = False
    ) -> None:
        """Derive the constants; keyed -- the keypad sets the lead."""
        self._leads = lead_s > 0 or keyed
        self._lead_s = Single(lead_s)
        self._share = filter_share(period_s, filter_s)
        self._per_period = Single(1 / period_s)
        self.keep(*[("rate_k_per_s", "f4", "_rate")] * self._leads)
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


class KeyedSwitch:
    """A lead and a hysteresis; the keypad may set either."""

    def __init__(
        self, algorithm: OnOff | ThreePosition, period_s: float, keyed: tuple[str, ...]
    ) -> None:
        """Derive the constants; keyed -- the fields that the keypad sets."""
        lead = algorithm.lead_s, algorithm.lead_filter_s
        self._lead = Lead(*lead, period_s, keyed="lead_s" in keyed)
        self._has_width = algorithm.hysteresis_k > 0 or "hysteresis_k" in keyed
        self._hysteresis = Single(algorithm.hysteresis_k)
        self._taken: dict[str, Single] = dict.fromkeys(keyed, ZERO)
        self._members: tuple[Member, ...] = (*self._lead.members, *((each, "f4") for each in keyed))

    def take(self, numbers: Numbers) -> None:
        """Take over the numbers that the keypad has set, for the next step."""
        self._taken = {each: numbers[each] for each in self._taken}
        self._hysteresis = self._taken.get("hysteresis_k", self._hysteresis)
        if "lead_s" in self._taken:
            self._lead.take(self._taken["lead_s"])

    def _values(self) -> tuple[Value, ...]:
        return (*self._lead.values(), *self._taken.values())

    def resume(self, values: Iterator[Value]) -> None:
        """Take over the next values, one for each of `members` of all switches."""
        self._lead.resume(values)
        self._taken = {each: next(values) for each in self._taken}
