"""An output that is switched on and off."""

from heatwright.sim.outputs.switch import attach

__all__ = ["attach"]
