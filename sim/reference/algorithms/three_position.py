"""Heater below a dead band, cooler above it (docs/control.md, "three_position")."""

from heatwright.sim.reference.algorithms.keyed_switch import KeyedSwitch
from heatwright.sim.reference.interfaces.keyed import Numbers
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.spec import ThreePosition


class ThreePositionControl(KeyedSwitch):
    """Switches heater or cooler, never both on, by the temperature expected `lead` later."""

    full_percent = FULL
    """The highest duty of the algorithm."""

    def __init__(
        self, algorithm: ThreePosition, period_s: float, keyed: tuple[str, ...] = ()
    ) -> None:
        """Derive the constants; keyed -- the fields that the keypad sets."""
        super().__init__(
            algorithm, period_s, keyed, ("heating", "u1", "_heating"), ("cooling", "u1", "cooling")
        )
        self._dead_band = Single(algorithm.dead_band_k)
        self._inside = Single(algorithm.dead_band_k - algorithm.hysteresis_k)
        if "hysteresis_k" in keyed:  # as the firmware subtracts it
            self._inside = self._dead_band - self._hysteresis

    def reset(self) -> None:
        """Start again after a fault."""
        super().reset()
        self._heating = 0
        self.cooling = 0

    def step(self, temperature_c: Single, last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""
        expected_c = self.expected_c(temperature_c, last_c, gap)
        self._heating = int(expected_c < setpoint_c - self._width(self._heating))
        self.cooling = int(expected_c > setpoint_c + self._width(self.cooling))
        return FULL if self._heating else ZERO

    def take(self, numbers: Numbers) -> None:
        """Take over the numbers that keys have set; the inner band follows from the hysteresis."""
        super().take(numbers)
        if "hysteresis_k" in numbers:
            self._inside = self._dead_band - self._hysteresis

    def _width(self, on: int) -> Single:
        """Return the distance from the setpoint at which heater or cooler goes on, or stays on."""
        return self._inside if on else self._dead_band


Control = ThreePositionControl
