"""The C shim over libsimavr: everything that happens once per event is done there.

``load()`` gives the compiled module; it is built on first use (see ``shim``).
"""

from heatwright.sim.native.shim import SimulatorMissing, load

__all__ = ["SimulatorMissing", "load"]
