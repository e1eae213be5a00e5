"""The C shim over libsimavr: it handles every single event of a simulation.

``load()`` returns the compiled module; it is built on first use (see ``shim``).
"""

from heatwright.sim.native.shim import SimulatorMissing, load
