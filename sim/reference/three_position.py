"""Heater below a dead band, cooler above it (docs/control.md, "three_position")."""

from heatwright.sim.reference.lead import Lead
from heatwright.sim.reference.members import Member, Value
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.spec import ThreePosition


class ThreePositionControl:
    """Switches heater and cooler, never both, on the temperature expected `lead` ahead."""

    full_percent = FULL
    """What the algorithm asks for at most."""

    def __init__(self, algorithm: ThreePosition, period_s: float) -> None:
        """Derive the constants."""
        self._lead = Lead(algorithm.lead_s, algorithm.lead_filter_s, period_s)
        self._dead_band = Single(algorithm.dead_band_k)
        self._inside = Single(algorithm.dead_band_k - algorithm.hysteresis_k)
        self.members: tuple[Member, ...] = (
            *self._lead.members,
            ("heating", "u1"),
            ("cooling", "u1"),
        )
        self.reset()

    def reset(self) -> None:
        """Start anew after a fault."""
        self._lead.reset()
        self._heating = 0
        self.cooling = 0

    def step(self, temperature_c: Single, last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""
        expected_c = self._lead.expected_c(temperature_c, last_c, gap)
        self._heating = int(expected_c < setpoint_c - self._width(self._heating))
        self.cooling = int(expected_c > setpoint_c + self._width(self.cooling))
        return FULL if self._heating else ZERO

    def values(self) -> tuple[Value, ...]:
        """Return the values of `members`."""
        return (*self._lead.values(), self._heating, self.cooling)

    def _width(self, on: int) -> Single:
        """Return how far from the setpoint heater or cooler has to be, to go or stay on."""
        return self._inside if on else self._dead_band


Control = ThreePositionControl
