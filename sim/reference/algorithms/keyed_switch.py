"""Shared by the switching algorithms: lead and hysteresis, which the keypad may set.

See docs/control.md, "on_off" and "three_position".
"""

from heatwright.sim.reference.interfaces.keyed import Numbers
from heatwright.sim.reference.numbers import ZERO, Kept, Single, faded, filter_share
from heatwright.spec import OnOff, ThreePosition


class KeyedSwitch(Kept):
    """A lead along the filtered slope, and a hysteresis; the keypad may set either.

    hysteresis_k, lead_s -- as the keypad has set them; 0 before the first step that uses them.
    """

    def __init__(
        self,
        algorithm: OnOff | ThreePosition,
        period_s: float,
        keyed: tuple[str, ...],
        *switched: tuple[str, str, str],
    ) -> None:
        """Derive the constants; keyed -- fields that the keypad sets; switched -- more members."""
        self._leads = algorithm.lead_s > 0 or "lead_s" in keyed
        self._lead_s = Single(algorithm.lead_s)
        self._share = filter_share(period_s, algorithm.lead_filter_s)
        self._per_period = Single(1 / period_s)
        self._has_width = algorithm.hysteresis_k > 0 or "hysteresis_k" in keyed
        self._hysteresis = Single(algorithm.hysteresis_k)
        self.hysteresis_k = self.lead_s = ZERO
        self.keep(
            *[("rate_k_per_s", "f4", "_rate")] * self._leads,
            *((each, "f4", each) for each in keyed),
            *switched,
        )
        self.reset()

    def reset(self) -> None:
        """Start again after a fault."""
        self._rate = ZERO

    def take(self, numbers: Numbers) -> None:
        """Take over the numbers that the keypad has set, for the next step."""
        self.hysteresis_k = numbers.get("hysteresis_k", ZERO)
        self.lead_s = numbers.get("lead_s", ZERO)
        self._hysteresis = numbers.get("hysteresis_k", self._hysteresis)
        self._lead_s = numbers.get("lead_s", self._lead_s)

    def expected_c(self, temperature_c: Single, last_c: Single, gap: int) -> Single:
        """Process a reading and return the temperature expected after the lead."""
        if not self._leads:
            return temperature_c
        if gap == 1:
            slope = (temperature_c - last_c) * self._per_period
            self._rate = faded(self._rate + self._share * (slope - self._rate))
        return temperature_c + self._lead_s * self._rate
