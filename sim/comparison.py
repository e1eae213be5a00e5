"""One row of a comparison: the same machine under another algorithm, setpoint or output."""

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.trace import Trace
from heatwright.spec import ComparisonRow, Controller, Event, ThermalNetwork, row_controller


def row_scenario(controller: Controller) -> tuple[Event, ...]:
    """Return the scenario of every row: the end of the file's scenario, without its events.

    Raises ValueError: the specification has no simulation.
    """
    return tuple(event for event in controller.simulated.scenario if event.for_s is not None)


def run_row(
    controller: Controller, row: ComparisonRow, *, plant: ThermalNetwork | None = None
) -> Trace:
    """Run a row with the reference model."""
    varied = row_controller(controller, row)
    return bench(varied, ReferenceDevice(varied), row_scenario(controller), plant=plant)
