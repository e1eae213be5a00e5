"""Which trips are counted for the lock-out, from docs/control.md."""

from heatwright.sim.host import Host
from heatwright.spec.breakable import breakable
from heatwright.spec.commands import lockout_of

UNCOUNTED = (14, 15, 16, 19, 23, 30)
"""Those of the controller, its supply, its host, and who has forgotten it."""


def lockout_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    controller, library = host.build.controller, host.library
    if lockout_of(controller) is None:
        return ""
    for rule in breakable(controller):
        host.power_up()
        library.host_acknowledge()
        library.fault.trips = 0
        library.fault_trip(rule.code, 0.0)
        if library.fault.trips != (rule.code not in UNCOUNTED):
            return f"{rule.id}: {library.fault.trips} trips are counted"
    return ""
