"""Which trips are counted for the lock-out, from docs/control.md."""

from heatwright.sim.host import Host
from heatwright.spec.breakable import rules_of
from heatwright.spec.commands import lockout_of

HOT = 6
UNCOUNTED = (14, 15, 16, 19, 23, 30)
"""Those of the controller, its supply, its host, and who has forgotten it."""


def lockout_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing."""
    controller, library = host.build.controller, host.library
    lockout = lockout_of(controller)
    if lockout is None:
        return ""
    for rule in rules_of(controller):
        host.power_up()
        library.host_acknowledge()
        library.fault.trips = 0
        library.fault_trip(rule.code, 0.0)
        if library.fault.trips != (rule.code not in UNCOUNTED):
            return f"{rule.id}: {library.fault.trips} trips are counted"
    for missing in (1, 0):
        host.power_up()
        library.host_acknowledge()
        library.fault.trips = max(0, lockout.trips - missing - 1)
        library.fault_trip(HOT, 0.0)
        if library.fault_is_locked() != (library.fault.trips == lockout.trips):
            return f"{library.fault.trips} trips of {lockout.trips} lock out, or do not"
    return ""
