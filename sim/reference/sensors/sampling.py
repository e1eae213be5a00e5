"""When an ideal sensor is sampled before a control step, and its reading."""

from importlib import import_module
from random import Random
from typing import Any

from heatwright.sim.coupling import sums_noise
from heatwright.sim.reference.numbers import SECOND_US, TICK_US
from heatwright.spec import Controller
from heatwright.spec.registry import module_of


class Sampler:
    """The reading of a sensor for the next step of a loop.

    All codes are sampled at the same time. If the machine makes noise, each is sampled in its own
    tick, because the noise of their sum is averaged.
    """

    def __init__(self, controller: Controller, name: str, noise_k: float = 0.0) -> None:
        """Derive when the sensor `name` has to be sampled.

        noise_k -- standard deviation of the noise that each sample adds, K.
        """
        sensor = controller.sensors[name]
        kind = import_module(module_of("sensor", "reference", sensor.kind))
        self._sensor: Any = kind.IdealSensor(sensor, controller.board)
        self._each = sums_noise(controller, name)
        early_us = round(self._sensor.sampled_before_step_s * SECOND_US)
        self._early_us = [early_us]
        if self._each:
            self._early_us = [turn * TICK_US for turn in range(self._sensor.oversample, 0, -1)]
        self._felt_c: list[float] = []
        self._noise_k = noise_k
        self._random = Random(0)  # noqa: S311 - no secret

    def due_us(self, step_us: int) -> int:
        """Return when to sample next, µs; the time of the step if all samples are taken."""
        looks = len(self._felt_c)
        return step_us - self._early_us[looks] if looks < len(self._early_us) else step_us

    @property
    def is_done(self) -> bool:
        """Whether the reading is complete."""
        return len(self._felt_c) == len(self._early_us)

    def look(self, temperature_c: float) -> None:
        """Sample the present temperature, °C."""
        if self._noise_k:
            temperature_c += self._random.gauss(0.0, self._noise_k)
        self._felt_c.append(temperature_c)

    def take(self) -> tuple[int, int]:
        """Return the reading's status and raw number, and begin the next one."""
        felt_c, self._felt_c = self._felt_c, []
        status, raw = self._sensor.read_all(felt_c) if self._each else self._sensor.read(felt_c[0])
        return status, raw
