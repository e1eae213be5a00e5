"""The delays of a controller from sensor to output, from the spec."""

from importlib import import_module

from heatwright.spec import Controller
from heatwright.spec.registry import module_of


def reading_age_s(controller: Controller, sensor: str) -> float:
    """Return how old a reading is at its control step, s."""
    spec = controller.sensors[sensor]
    module = import_module(module_of("sensor", "reference", spec.kind))
    return float(module.IdealSensor(spec, controller.board).sampled_before_step_s)


def output_delay_s(controller: Controller, output: str, period_s: float) -> float:
    """Return the mean delay until the output takes a new duty over, s.

    A PWM takes it over in its next period, a time-proportional output in its next window; a window
    as long as the control period begins with the step itself.
    """
    spec = controller.switches[output]
    if spec.frequency_hz:
        return 0.5 / spec.frequency_hz
    return max(0.0, spec.cycle_s - period_s) / 2
