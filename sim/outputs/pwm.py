"""An output that is driven by a timer's pulses."""

from heatwright.sim.outputs.switch import attach

__all__ = ["attach"]
