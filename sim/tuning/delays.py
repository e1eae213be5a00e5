"""How late a controller acts on what its sensor feels, from the specification."""

from __future__ import annotations

from importlib import import_module

from heatwright.spec import Controller
from heatwright.spec.registry import module_of


def reading_age_s(controller: Controller, sensor: str) -> float:
    """Return how old a reading is at its control step, s."""
    spec = controller.sensors[sensor]
    module = import_module(module_of("sensor", "reference", spec.kind))
    return float(module.IdealSensor(spec, controller.board).sampled_before_step_s)


def output_delay_s(controller: Controller, output: str, period_s: float) -> float:
    """Return how long a duty waits, on average, until the output takes it over, s.

    A PWM takes it over with its next period, a time-proportional output with its next window; one
    that is as long as the control period begins with the step itself.
    """
    spec = controller.switches[output]
    if spec.frequency_hz:
        return 0.5 / spec.frequency_hz
    return max(0.0, spec.cycle_s - period_s) / 2
