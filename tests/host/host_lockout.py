"""Which trips are counted for the lock-out, and that none is forgotten; from docs/control.md."""

from heatwright.sim.host import Host
from heatwright.spec.breakable import rules_of
from heatwright.spec.commands import lockout_of

HOT, MEMORY_DAMAGED = 6, 29
UNCOUNTED = (14, 15, 16, 19, 23, 30)
"""Those of the controller, its supply, its host, and who has forgotten it."""


def restored_problem(host: Host) -> str:
    """Say whether a processor that jumps to where the start restores a fault clears the latch."""
    library = host.library
    host.power_up()
    library.host_acknowledge()
    library.fault_trip(HOT, 0.0)
    library.fault_restore([{"code": 0}])
    library.fault_judge(True, 0.0)
    code = int(library.fault.code)
    return "" if code == MEMORY_DAMAGED else f"nothing restored over {HOT} leaves {code} latched"


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
