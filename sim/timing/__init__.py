"""The timing of a binary, measured to the cycle in the simulated processor."""

from heatwright.sim.timing.figures import Cost, Figure, Timing
from heatwright.sim.timing.measure import measure
