"""The C shim over libsimavr: it does all the work of single events.

``load()`` returns the compiled module; it is built on first use (see ``shim``).
"""

from heatwright.sim.native.shim import SimulatorMissing, load

__all__ = ["SimulatorMissing", "load"]
