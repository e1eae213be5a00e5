from rig.commands import heatwright

__all__ = ["heatwright"]
