"""Measure, limit and check the current of a heater.

docs/control.md, "Current", and the rules 20 to 22 of "Protections".
"""

from heatwright.sim.reference.numbers import FULL, ZERO, Kept, Single, steps
from heatwright.sim.reference.protection.rules import counted
from heatwright.sim.reference.sensors.current import Converter
from heatwright.spec import Controller, Loop, Switch

OVER_CURRENT = 20
CURRENT_WHILE_OFF = 21
NO_CURRENT = 22

LASTING_S = 0.5
FEWEST_STEPS = 5
IDLE_SHARE = 0.05
IDLE_ADC_STEPS = 3
START_PERCENT = Single(25)
"""The first limit of a heater's duty, and its increase per step."""
LEAST_PERCENT = Single(0.1)
HALF, TWO = Single(0.5), Single(2)


class Limiter(Kept):
    """Watches and limits a heater's current.

    amperes_of -- converts a sum of codes; idle_a -- a lower current counts as none;
    amperes_per_percent -- the expected current per % of duty.
    """

    def __init__(self, controller: Controller, loop: Loop) -> None:
        """Derive the constants of a loop whose heater's current is measured.

        Raises ValueError: it is not measured.
        """
        output = controller.switches[loop.heater]
        if output.current is None:
            raise ValueError(f"The current of {loop.heater} is not measured")
        current = output.current
        self.amperes_of = Converter(controller.ammeters[current.sensor], controller.board)
        root = rms_to_mean(output)
        self._limit = None if current.limit_a is None else Single(current.limit_a * root)
        self._trip = Single(current.over_a * root)
        idle_a = max(IDLE_SHARE * current.nominal_a * root, IDLE_ADC_STEPS * self.amperes_of.step_a)
        self.idle_a = Single(idle_a)
        self.amperes_per_percent = Single((output.power_w or 0.0) / (output.supply_v or 0.0) / 100)
        self._lasting = max(FEWEST_STEPS, steps(LASTING_S, loop))
        self.keep(
            ("raw", "i2", "_raw"),
            ("amperes", "f4", "_amperes"),
            ("applied_percent", "f4", "_applied"),
            *[("limit_percent", "f4", "_limit_percent")] * (self._limit is not None),
            ("leak_steps", "u2", "_leak_steps"),
            ("none_steps", "u2", "_none_steps"),
        )
        self._raw = self._leak_steps = self._none_steps = 0
        self._amperes = self._applied = self._limit_percent = ZERO

    @property
    def top_percent(self) -> Single:
        """The highest duty that the heater may have, %."""
        return FULL if self._limit is None else self._limit_percent

    def measure(self, raw: int, applied_percent: Single) -> None:
        """Process a reading, and the heater's duty during it."""
        self._raw = raw
        self._applied = applied_percent
        self._amperes = self.amperes_of(raw)
        if self._limit is not None:
            self._limit_percent = self._limited(self._limit)

    def watch(self) -> int:
        """Return the code of the fault, 0 for none."""
        if self._amperes >= self._trip:
            return OVER_CURRENT
        leaks = self._applied == ZERO and self._amperes >= self.idle_a
        self._leak_steps = counted(self._leak_steps) if leaks else 0
        if self._leak_steps >= self._lasting:
            return CURRENT_WHILE_OFF
        due = self._applied * self.amperes_per_percent
        lacks = due >= TWO * self.idle_a and self._amperes < HALF * due
        self._none_steps = counted(self._none_steps) if lacks else 0
        return NO_CURRENT if self._none_steps >= self._lasting else 0

    def forget(self) -> None:
        """Reset the counters, because a fault is latched."""
        self._leak_steps = self._none_steps = 0

    def _limited(self, limit_a: Single) -> Single:
        if self._applied == ZERO:
            return START_PERCENT
        flows = self._amperes >= self.idle_a
        root = self._applied * limit_a / max(self._amperes, self.idle_a)
        wanted = max(root * root / FULL, LEAST_PERCENT if flows else START_PERCENT)
        rising = self._limit_percent + START_PERCENT
        return min(wanted, rising if rising <= FULL else FULL)


def rms_to_mean(output: Switch) -> float:
    """Return the mean current at full duty per ampere of its root mean square."""
    return output.rated_v / output.supply_v if output.supply_v and output.rated_v else 1.0


def limiter_of(controller: Controller, loop: Loop) -> Limiter | None:
    """Return the limiter of a loop's heater, None if its current is not measured."""
    return Limiter(controller, loop) if controller.outputs[loop.heater].current else None
