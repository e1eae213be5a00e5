"""Autotuning by a relay experiment on the machine (docs/control.md, "Autotune")."""

from typing import NamedTuple

from heatwright.sim.reference.algorithms.tuning_rule import Constants, Found, Swings, found_by
from heatwright.sim.reference.inputs import TUNING, Gains, Limits
from heatwright.sim.reference.numbers import ZERO, Kept, Single, clamp, steps
from heatwright.spec import Autotune, Loop, Pid

NONE, RUNNING, DONE, TIMED_OUT, STOPPED, TOO_HOT, NO_USE = range(7)
"""Results of the experiment, as numbers in the program."""
COOL, HEAT, SLOPE, COAST, RELAY_OFF, RELAY_ON = range(6)
"""Phases of the experiment, in their order."""

FEWEST_CYCLES, MOST_CYCLES = 3, 20
LONGEST_STEPS = 65535

COLD_K, SLOPE_K, TURN_K, TOO_HOT_K = Single(20), Single(10), Single(1), Single(20)
LEAST_HYSTERESIS_K, MOST_HYSTERESIS_K = Single(1), Single(5)
LARGEST_GAIN = Single(1e6)
HALF = Single(0.5)


STEPS = ("steps", "half_steps", "on_steps", "on_sum", "off_sum")
"""Members that count steps."""
MEASURED = ("from_c", "rise", "peak_c", "hysteresis_k", "high_c", "swing_sum", "peak_sum")
"""Members with temperatures, and what follows from them."""


class Moment(NamedTuple):
    """The inputs of the experiment at a step with a reading."""

    temperature_c: Single
    last_c: Single
    setpoint_c: Single


class Tuner(Kept):
    """The relay experiment of one loop."""

    def __init__(self, loop: Loop, autotune: Autotune, algorithm: Pid) -> None:
        """Derive the constants from the spec of a loop with autotune."""
        self.keep(
            ("result", "u1", "result"),
            ("starts", "u1", "starts"),
            ("cycles", "u1", "_cycles"),
            ("phase", "u1", "phase"),
            ("switches", "u1", "_switches"),
            *((name, "u2", f"_{name}") for name in STEPS),
            *((name, "f4", f"_{name}") for name in MEASURED),
            *((name, "f4", f"_found.{name}") for name in Found._fields),
        )
        self._constants = Constants.of(algorithm, autotune, loop)
        self._swing_share = Single(autotune.swing_percent / 100)
        self.swing_percent = self._constants.swing_percent
        self._limits: Limits | None = None
        self._usual_cycles = autotune.cycles
        self._longest = min(LONGEST_STEPS, steps(autotune.timeout_s, loop))
        self.result = NONE
        self.starts = 0
        self._cycles = 0
        self._clear()

    @property
    def gains(self) -> Gains:
        """The gains that the experiment has found; 0 before."""
        return Gains(self._found.kp, self._found.ki, self._found.kd)

    def take_limits(self, limits: Limits) -> None:
        """Use these limits instead of the spec's."""
        self._limits = limits
        self.swing_percent = limits.output_maximum * self._swing_share

    def start(self, cycles: int | None = None) -> None:
        """Start the experiment, with the spec's number of cycles if none is given."""
        wanted = self._usual_cycles if cycles is None else cycles
        self._cycles = min(max(wanted, FEWEST_CYCLES), MOST_CYCLES)
        self.starts = (self.starts + 1) & 0xFF
        self._clear()
        self.result = RUNNING

    def stop_unless(self, mode: int, *, fault: bool) -> None:
        """Stop the experiment if the loop no longer tunes, or must not heat."""
        if self.result == RUNNING and (mode != TUNING or fault):
            self.result = STOPPED

    def step(self, moment: Moment | None, *, paused: bool = False) -> Single:
        """Run a step, with or without a reading, and return the duty in percent.

        The experiment ends as timed out if an input of the machine pauses the heat.
        """
        if self.result != RUNNING:
            return ZERO
        self._steps += 1
        self._half_steps += 1
        if self._steps >= self._longest or paused:
            self.result = TIMED_OUT
        elif moment is not None:
            self._look(moment)
        heats = self.phase in (HEAT, SLOPE, RELAY_ON)
        return self.swing_percent if self.result == RUNNING and heats else ZERO

    def _clear(self) -> None:
        self.phase = COOL
        self._switches = self._steps = self._half_steps = 0
        self._on_steps = self._on_sum = self._off_sum = 0
        self._from_c = self._rise = self._peak_c = ZERO
        self._hysteresis_k = self._high_c = ZERO
        self._swing_sum = self._peak_sum = ZERO
        self._found = Found(*[ZERO] * len(Found._fields))

    def _look(self, moment: Moment) -> None:
        temperature_c, last_c, target_c = moment
        middle_c = (temperature_c + last_c) * HALF
        if self.phase != COOL and temperature_c >= target_c + TOO_HOT_K:
            self.result = TOO_HOT
        elif self.phase in (COOL, HEAT, SLOPE):
            self._heat_up(temperature_c, middle_c, target_c)
        elif self.phase == RELAY_ON:
            if temperature_c >= target_c + self._hysteresis_k:
                self._switch_off(temperature_c, middle_c)
        else:
            self._peak_c = max(self._peak_c, temperature_c)
            self._coast(temperature_c, middle_c, target_c)

    def _heat_up(self, temperature_c: Single, middle_c: Single, target_c: Single) -> None:
        if self.phase == COOL:
            if temperature_c <= target_c - COLD_K:
                self.phase = HEAT
        elif self.phase == HEAT:
            if temperature_c >= target_c - SLOPE_K:
                self.phase = SLOPE
                self._half_steps = 0
                self._from_c = middle_c
        elif temperature_c >= target_c:
            self.phase = COAST
            time_s = self._constants.time_s(Single(self._half_steps))
            self._rise = (middle_c - self._from_c) / time_s
            self._peak_c = temperature_c

    def _coast(self, temperature_c: Single, middle_c: Single, target_c: Single) -> None:
        if self.phase == RELAY_OFF:
            if temperature_c <= target_c - self._hysteresis_k:
                self._switch_on(middle_c)
        elif temperature_c <= target_c - TURN_K:
            self._hysteresis_k = clamp(
                self._peak_c - target_c, LEAST_HYSTERESIS_K, MOST_HYSTERESIS_K
            )
            self.phase = RELAY_OFF

    def _switch_off(self, temperature_c: Single, middle_c: Single) -> None:
        self.phase = RELAY_OFF
        self._on_steps = self._half_steps
        self._half_steps = 0
        self._high_c = middle_c
        self._peak_c = temperature_c

    def _switch_on(self, middle_c: Single) -> None:
        if self._switches >= 2:
            self._on_sum += self._on_steps
            self._off_sum += self._half_steps
            self._swing_sum = self._swing_sum + (self._high_c - middle_c)
            self._peak_sum = self._peak_sum + (self._peak_c - self._high_c)
        if self._switches == self._cycles:
            self._finish()
        self._switches += 1
        self.phase = RELAY_ON
        self._half_steps = 0

    def _finish(self) -> None:
        swings = Swings(
            Single(self._cycles - 1),
            Single(self._on_sum),
            Single(self._off_sum),
            self._swing_sum,
            self._peak_sum,
            self._rise,
        )
        if not swings.are_measured:
            self.result = NO_USE
            return
        constants = self._constants
        if self._limits is not None:
            constants = constants.within(self._limits, self._swing_share)
        self._found = found_by(swings, constants)
        usable = all(gain <= LARGEST_GAIN for gain in self.gains)
        self.result = DONE if usable else NO_USE
