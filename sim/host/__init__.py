"""The host build: the generated C of all loops, compiled unchanged by gcc and called from Python.

The third executable beside the reference model and the AVR binary. Where the reference differs
from it, the algorithm is wrong; where the binary does, the C means something else on the AVR.
Structures are packed, as on the AVR, and the headers of avr-libc are our own few (`include/`).
"""

from heatwright.sim.host.build import HostBuild, HostBuildFailed, build_host
from heatwright.sim.host.firmware import Command, Host

__all__ = ["Command", "Host", "HostBuild", "HostBuildFailed", "build_host"]
