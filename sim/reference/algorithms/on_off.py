"""On-off control with hysteresis and lead (docs/control.md, "on_off")."""

from heatwright.sim.reference.algorithms.keyed_switch import KeyedSwitch
from heatwright.sim.reference.numbers import FULL, ZERO, Single
from heatwright.spec import OnOff


class OnOffControl(KeyedSwitch):
    """Switches the heater at the setpoint, by the temperature that is expected `lead` later."""

    full_percent = FULL
    """The highest duty of the algorithm."""

    def __init__(self, algorithm: OnOff, period_s: float, keyed: tuple[str, ...] = ()) -> None:
        """Derive the constants; keyed -- the fields that the keypad sets."""
        super().__init__(algorithm, period_s, keyed, ("heating", "u1", "_heating"))

    def reset(self) -> None:
        """Start again after a fault."""
        super().reset()
        self._heating = 0

    def step(self, temperature_c: Single, last_c: Single, gap: int, setpoint_c: Single) -> Single:
        """Return the duty in percent."""
        expected_c = self.expected_c(temperature_c, last_c, gap)
        if self._has_width:
            if expected_c >= setpoint_c + self._hysteresis:
                self._heating = 0
            elif expected_c <= setpoint_c - self._hysteresis:
                self._heating = 1
        else:
            self._heating = 0 if expected_c >= setpoint_c else 1
        return FULL if self._heating else ZERO


Control = OnOffControl
