"""Faults that trip rules effort_high and effort_low: wrong readings, and a weaker heater."""

from collections.abc import Iterator
from functools import partial

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bears import bears_c
from heatwright.sim.faults.effects import Felt, Heated
from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.machine import asked_share, share_for, steady_c
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel
from heatwright.sim.plants import profile_c
from heatwright.spec.loops import Effort

SEEN, ASKED = 0.75, 0.9
"""Shares of full duty: the effort band's upper limit must be below the first for a fault to be
detectable; an aged heater then needs the second."""
BEYOND = 1.15
"""Effort of a machine whose reading has drifted, as a multiple of the band's upper limit."""
SPARE = 0.05
"""Margin, as a share of the nodes' limits above ambient: a drift is detected late."""
SLOW = 4.0
"""A drift takes SLOW filter times, and is SLOW times slower than `rise_rate`."""
STANDING_K = 1.0
"""How far above the setpoint and its hysteresis the reading stays."""
FILTERS, TIMES = 4.0, 2.0
"""How long a machine is watched: FILTERS filter times plus TIMES times the rule's `for`."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults at which rules effort_high and effort_low must trip, if they can."""
    effort = site.loop.protection.effort
    if effort is None or site.loop.cooler is not None:
        return
    watch_s = FILTERS * effort.band.filter_s + TIMES * effort.for_s
    if site.loop.algorithm.continuous:  # a switching loop commands full power: rule 10 trips
        yield from _aged(site, effort, watch_s)
    yield from _drifting(site, effort, watch_s)
    yield from _standing_high(site, effort, watch_s)


def _held(site: Site, setpoint_c: float) -> World:
    """Return a world at its setpoint."""
    world = starts.begun(site, setpoint_c)
    world.set_setpoint(setpoint_c)
    starts.first_steps(world)
    return world


def _setpoints_c(site: Site) -> list[float]:
    """List the setpoints that need more than the loop's least duty, the highest setpoint first."""
    highest_c, ambient_c = starts.highest_c(site), site.ambient_c
    least, _ = site.loop.algorithm.steady_percent
    least_c = steady_c(site, asked_share(site, least), ambient_c=ambient_c)
    reached = [each for each in starts.setpoints_c(site) if each <= highest_c]
    return [each for each in reversed(reached) if each > max(ambient_c, least_c)]


def _aged(site: Site, effort: Effort, watch_s: float) -> Iterator[Fault]:
    """Yield an aged heater, or a low supply: holding the setpoint needs nearly full duty."""
    _, full = site.loop.algorithm.steady_percent
    seen_c = [each for each in _setpoints_c(site) if effort.band.at(each)[0] < SEEN * full]
    if not seen_c:
        return
    takes = share_for(site, seen_c[0], ambient_c=site.ambient_c)
    aged = Heated(site.loop.heater, effects.weakened(takes / asked_share(site, ASKED * full)))
    yield Fault("heater_aged", lambda: _held(site, seen_c[0]), aged, aged.mend, watch_s=watch_s)


def _drifting(site: Site, effort: Effort, watch_s: float) -> Iterator[Fault]:
    """Yield a reading that drifts low, if all nodes withstand the heat that follows."""
    setpoint_c = min(_setpoints_c(site), default=None)
    if setpoint_c is None:
        return
    takes = BEYOND * effort.band.at(setpoint_c)[0]
    ambient_c = site.ambient_c
    if not takes < site.loop.algorithm.steady_percent[1]:
        return
    true_c = steady_c(site, asked_share(site, takes), ambient_c=ambient_c)
    bears = bears_c(site.controller, site.network)
    nodes = profile_c(site.controller, site.network, site.loop_name, true_c, ambient_c=ambient_c)
    limits_c = {node: ambient_c + (1 - SPARE) * (bears[node] - ambient_c) for node in nodes}
    if any(each_c > limits_c[node] for node, each_c in nodes.items()):
        return
    low_k, fastest_k_per_s = true_c - setpoint_c, site.loop.protection.rise_rate_k_per_s / SLOW
    rate_k_per_s = min(low_k / (SLOW * effort.band.filter_s), fastest_k_per_s)

    def change(world: World) -> Feel:
        began_s = world.now_s
        return lambda felt_c: felt_c - min(low_k, rate_k_per_s * (world.now_s - began_s))

    drifts, make = Felt(site.loop.sensor, change), partial(_held, site, setpoint_c)
    drift_s = low_k / rate_k_per_s
    yield Fault("reading_drifts_low", make, drifts, drifts.mend, watch_s=watch_s + drift_s)


def _standing_high(site: Site, effort: Effort, watch_s: float) -> Iterator[Fault]:
    """Yield a reading that stays above the setpoint: the heater is off, and the machine cools."""
    seen_c = [each for each in _setpoints_c(site) if effort.band.at(each)[1] > 0]
    if not seen_c:
        return
    stands_c = seen_c[0] + site.loop.algorithm.swing_k / 2 + STANDING_K
    rate_k_per_s = site.loop.protection.rise_rate_k_per_s / SLOW
    rises = Felt(site.loop.sensor, lambda world: effects.drifting(world, rate_k_per_s, stands_c))
    make = partial(_held, site, seen_c[0])
    yield Fault("reading_stands_high", make, rises, rises.mend, watch_s=watch_s)
