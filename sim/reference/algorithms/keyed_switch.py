"""Shared by the switching algorithms: lead and hysteresis, which the keypad may set."""

from heatwright.sim.reference.algorithms.lead import Lead
from heatwright.sim.reference.interfaces.keyed import Numbers
from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import ZERO, Single
from heatwright.spec import OnOff, ThreePosition


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
        self._members: tuple[Member, ...] = (
            *self._lead.members,
            *((each, "f4") for each in keyed),
        )

    def take(self, numbers: Numbers) -> None:
        """Take over the numbers that the keypad has set, for the next step."""
        self._taken = {each: numbers[each] for each in self._taken}
        self._hysteresis = self._taken.get("hysteresis_k", self._hysteresis)
        if "lead_s" in self._taken:
            self._lead.take(self._taken["lead_s"])

    def _values(self) -> tuple[Value, ...]:
        return (*self._lead.values(), *self._taken.values())
