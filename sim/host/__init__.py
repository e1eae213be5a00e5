"""The host build: the generated C of all loops, compiled unchanged by gcc, called from Python.

It is the third executable beside the reference model and the AVR binary. If the reference model
differs from it, the algorithm is wrong; if the binary differs, the C behaves otherwise on the AVR.
Structures are packed, as on the AVR; own headers replace those of avr-libc (`include/`).
"""

from heatwright.sim.host.build import HostBuild, HostBuildFailed, build_host
from heatwright.sim.host.firmware import Command, Host
