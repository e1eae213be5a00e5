"""Compares how hot a machine's nodes become, while its sensor reads wrong, with their limits.

If the nodes withstand that, a worse case is tried: the sensor has fallen out, and somebody
acknowledges each trip and commands heat again, until the lock-out refuses it.
"""

import math
from collections.abc import Callable, Iterator

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.commands import setpoints_c
from heatwright.spec.controller import Controller, Lockout
from heatwright.spec.loops import Loop
from heatwright.spec.physics.heated_loop import HeatedLoop, most_borne
from heatwright.spec.physics.stand import Peak, Stand, counted_for_s, times_of
from heatwright.spec.physics.stuck import Times
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, celsius, duration

SHARE = 0.02
"""Largest error of these peaks compared with `verify`, as a share of the rise above ambient."""


def nodes_bear_the_maximum(machine: Machine, heated: HeatedLoop) -> Findings:
    """Find nodes whose limit is below the temperature that they can keep without a trip."""
    maximum_c = machine.loop.protection.maximum_c
    most_k = min(maximum_c - heated.ambient_c, heated.plant.steady_k(heated.full_w))
    for node, above_k in zip(heated.nodes, heated.plant.held_k(most_k), strict=True):
        bears_c, rests_c = heated.given_c.get(node), heated.ambient_c + above_k
        if bears_c is not None and bears_c < rests_c * (1 - 1e-9):
            yield Finding(
                ("simulation", "plant", "bears", node),
                f"with the sensor at {celsius(heated.ambient_c + most_k)}, which "
                f"{'.'.join(map(str, machine.path))}.protection.maximum allows without a trip, "
                f"{node} is at {about(rests_c)} °C",
                f"Use at least {about(math.ceil(10 * rests_c) / 10)} °C, or a lower maximum",
                (*machine.because_of, (*machine.path, "protection", "maximum")),
            )


def lying_sensors_are_borne(
    controller: Controller, machine: Machine, heated: HeatedLoop
) -> Findings:
    """Find rules that trip too late for a node when the sensor reads wrong."""
    loop = machine.loop
    if loop.protection.maximum_c <= heated.highest_c:
        return  # another check reports it; the nodes' limits follow from a valid maximum
    stand = Stand(loop, heated, setpoints_c(controller, str(machine.path[1])))
    times, lockout = times_of(loop), controller.lockout
    found = stand.worst(times, SHARE)
    if found is not None:
        yield Finding(*_parts(machine, stand, found), machine.because_of)
    elif lockout is not None and lockout.trips > 1:
        yield from _repeated_trips(machine, stand, times, lockout)


def _repeated_trips(machine: Machine, stand: Stand, times: Times, lockout: Lockout) -> Findings:
    """Find a lock-out that comes after too many trips, or forgets them too soon."""
    because = (*machine.because_of, (*machine.path, "protection"))
    found = stand.insisted(times, lockout.trips)
    if found is not None:
        allowed = stand.trips_borne(times, lockout.trips - 1)
        yield Finding(
            ("safety", "lockout", "trips"),
            f"if somebody acknowledges each trip of a sensor that has fallen out, until the "
            f"lock-out after {lockout.trips} trips, {_reaches(found)}",
            f"Use at most {allowed}{_or_bears(found)}",
            because,
        )
        return
    found = stand.uncounted(times, lockout.within_s)
    if found is not None:
        longer_s = counted_for_s(stand, times, lockout.within_s)
        yield Finding(
            ("safety", "lockout", "within"),
            f"if a sensor has fallen out and somebody acknowledges each trip "
            f"{duration(lockout.within_s)} after the one before, the lock-out never comes, and "
            f"{_reaches(found)}",
            (f"Use at least {duration(longer_s)}" if longer_s else "Let a rule trip sooner")
            + _or_bears(found),
            because,
        )


def _reaches(peak: Peak) -> str:
    return (
        f"{peak.node} reaches {about(peak.peak_c)} °C, and it withstands {about(peak.bears_c)} °C"
    )


def _or_bears(peak: Peak) -> str:
    return f"; or, if it withstands more, write {_bears(peak)}"


def _bears(peak: Peak) -> str:
    return f"simulation.plant.bears: {{{peak.node}: {math.ceil(peak.peak_c)} °C}}"


def _parts(machine: Machine, stand: Stand, found: Peak) -> tuple[Path, str, str]:
    """Return the key to change, the reason, and the remedy with a number that is enough."""
    path = (*machine.path, "protection")
    reason = (
        f"with a sensor {found.words}, {found.node} reaches {about(found.peak_c)} °C before a rule "
        f"trips, and it withstands {about(found.bears_c)} °C"
    )
    for key, times, safe_s in _safe_times(machine.loop, stand):
        left = stand.peak_c(found.node, times)
        return (
            (*path, *key),
            reason,
            f"Use at most {duration(safe_s)}, with which it reaches {about(left)} °C"
            f"{_or_bears(found)}",
        )
    return (
        path,
        f"{reason}; no rule can trip sooner without tripping on the healthy machine, too",
        f"Use a heater of less power, or, if it withstands that, write {_bears(found)}",
    )


def _safe_times(loop: Loop, stand: Stand) -> Iterator[tuple[tuple[str, str], Times, float]]:
    """Yield for each rule its key, all times with its longest safe one, and that time, s.

    A time is safe if it protects all nodes, and never trips a healthy machine.
    """
    now, heated = times_of(loop), stand.heated
    heating, frozen = loop.protection.heating, loop.protection.frozen
    if heating is not None:
        needs_s = heated.slowest_rise(heating.rise_k)[0] + heated.late_s
        yield from _longest(
            stand, ("heating", "within"), needs_s, now.within_s,
            lambda each_s: now._replace(within_s=each_s),
        )  # fmt: skip
    if frozen is not None:
        power_w = min(heated.power_w * frozen.holding_percent / 100, heated.full_w)
        if power_w > heated.hold_w:
            needs_s = heated.longest_still_s(power_w) + heated.late_s
            yield from _longest(
                stand, ("frozen", "for"), needs_s, now.for_s,
                lambda each_s: now._replace(for_s=each_s),
            )  # fmt: skip


def _longest(
    stand: Stand,
    key: tuple[str, str],
    needs_s: float,
    now_s: float,
    times: Callable[[float], Times],
) -> Iterator[tuple[tuple[str, str], Times, float]]:
    if needs_s >= now_s or stand.worst(times(needs_s)) is not None:
        return
    low_s = most_borne(lambda each_s: stand.worst(times(each_s)) is None, needs_s, now_s)
    unit = 10.0 ** (math.floor(math.log10(low_s)) - 2)
    rounded_s = math.floor(low_s / unit) * unit
    if rounded_s > needs_s:
        yield key, times(rounded_s), float(f"{rounded_s:.3g}")
