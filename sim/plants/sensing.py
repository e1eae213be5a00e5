"""Sensors of the plant: dead time and noise of a tip, filter of a current sensor."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from heatwright.spec import Sense

NOISE_BLOCK = 4096
"""Random numbers per block: drawing them one by one would take longer than the plant."""


class Feeler:
    """One sensor's tip."""

    def __init__(  # noqa: PLR0913, PLR0917 - a tip's properties
        self,
        state: int,
        sense: Sense,
        initial_c: float,
        step_s: float,
        seed: tuple[int, int],
        error_k: float = 0.0,
    ) -> None:
        """Start in the steady state.

        state -- index of the plant's state that the sensor follows; sense -- dead time and noise;
        initial_c -- temperature up to now, °C; step_s -- time between two calls of `feel`, s;
        seed -- seed of the noise; error_k -- the sensor's constant error, K.
        """
        self.state = state
        self.noise_k, self.error_k = sense.noise_k, error_k
        whole = math.ceil(sense.delay_s / step_s)
        self.older_share = 1 - (whole - sense.delay_s / step_s)
        self._past = deque([initial_c] * (whole + 1), maxlen=whole + 1)
        self._random = np.random.default_rng(seed)
        self._noise: list[float] = []
        self.felt_c = initial_c + error_k + self.draw()

    def feel(self, states: Sequence[float]) -> None:
        """Follow the plant by one step."""
        past = self._past
        past.append(states[self.state])
        felt_c = past[0]
        if len(past) > 1:
            felt_c = self.older_share * felt_c + (1 - self.older_share) * past[1]
        felt_c += self.error_k
        self.felt_c = felt_c + self.draw() if self.noise_k else felt_c

    @property
    def past_c(self) -> list[float]:
        """Past temperatures for the dead time, the oldest first, °C."""
        return list(self._past)

    def left_k(self) -> list[float]:
        """Return the drawn but unused noise, K, and drop it here; the last number is the next."""
        left, self._noise = self._noise or self._drawn(), []
        return left

    def _drawn(self) -> list[float]:
        drawn: list[float] = self._random.normal(0.0, self.noise_k, NOISE_BLOCK).tolist()
        return drawn

    def draw(self) -> float:
        """Return the noise of the next step, K."""
        if not self.noise_k:
            return 0.0
        if not self._noise:
            self._noise = self._drawn()
        return self._noise.pop()


class Ammeter:
    """A sensor of a heater's mean current, with a first-order filter."""

    def __init__(self, sense: Sense, full_a: float, step_s: float) -> None:
        """Start without a current.

        sense -- the heater and the filter's time constant; full_a -- current of the heater while it
        is on, A; step_s -- time between two calls of `follow`, s.
        """
        self.output = sense.of or ""
        self.full_a = full_a
        self.share = 1 - math.exp(-step_s / sense.lag_s) if sense.lag_s else 1.0
        self.amperes = 0.0

    def follow(self, active: float) -> None:
        """Advance by one step, with the heater's mean active fraction over it, 0..1."""
        self.amperes += self.share * (active * self.full_a - self.amperes)
