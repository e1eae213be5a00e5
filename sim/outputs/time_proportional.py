"""An output that is on for part of each window."""

from heatwright.sim.outputs.switch import attach

__all__ = ["attach"]
