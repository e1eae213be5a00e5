"""Current limits of a heater whose current is measured."""

from heatwright.sim.circuits import reference_v
from heatwright.sim.faults.world import Site
from heatwright.sim.reference.protection.limiter import IDLE_ADC_STEPS, IDLE_SHARE, rms_to_mean
from heatwright.spec import Current, Switch, full_a

CODES = 1024
SOFT_START = 0.25


class Measured:
    """A heater's currents, A.

    full_a -- while the pin is on; all others are means: mean_a -- at 100 % duty; idle_a -- less
    counts as no current; over_a -- more trips; limit_a -- the limit to which the duty is reduced.
    """

    def __init__(self, output: Switch, current: Current, step_a: float) -> None:
        self.full_a = full_a(output) or 0.0
        self.mean_a = (output.power_w or 0.0) / (output.supply_v or 1.0)
        root = rms_to_mean(output)
        self.idle_a = max(IDLE_SHARE * current.nominal_a * root, IDLE_ADC_STEPS * step_a)
        self.over_a = current.over_a * root
        self.limit_a = None if current.limit_a is None else current.limit_a * root


def measured(site: Site) -> Measured | None:
    """Return the currents of the loop's heater; None if they are not measured."""
    output = site.controller.switches[site.loop.heater]
    if output.current is None:
        return None
    sensor = site.controller.ammeters[output.current.sensor]
    step_a = reference_v(sensor, site.controller.board) / CODES / sensor.scale_v_per_a
    return Measured(output, output.current, step_a)
