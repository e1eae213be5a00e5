"""The usual forms of a fault: the loop heats when it occurs."""

from heatwright.sim.faults import starts
from heatwright.sim.faults.fault import Act, Fault, Judge, Trip, no_complaint, nothing
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.world import Site


def harmless(site: Site, name: str, cause: Act, for_s: float, judge: Judge = no_complaint) -> Fault:
    """Return a fault that no rule may see, watched for a time, s."""
    return Fault(name, lambda: starts.heating(site), cause, calm=True, watch_s=for_s, judge=judge)


def tripping(site: Site, name: str, cause: Act, trip: Trip, cure: Act = nothing) -> Fault:
    """Return a fault with the trip that must come."""
    return Fault(name, lambda: starts.heating(site), cause, cure, trip=trip)


def watched(site: Site, name: str, cause: Act, cure: Act) -> Fault:
    """Return a fault that is watched until any rule that sees it trips, and again after that."""
    return Fault(name, lambda: starts.heating(site), cause, cure, watch_s=watch_s(site), again=True)
