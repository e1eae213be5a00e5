"""Faults of fans with a `proof`: the fan stands still, or its contact or tachometer is broken."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from heatwright.sim.faults import effects
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Act, Fault, Trip, tripping, watched
from heatwright.sim.faults.sensing.readings import CURRENT_RULES
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.relay import Wire
from heatwright.spec import Proof, Tachometer

SLOW, FAST = 0.88, 1.1
"""Speeds just outside a tachometer's limits, as shares of those limits: off by almost two pulses
in a window of 16."""
HIGHEST = 0.6
"""Largest share of a pulse's period in which the line may be low, or high."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the fans whose proof is checked in the loop's steps."""
    for fan in site.facts.proven:
        yield _unproven(site, fan, f"{fan}_stuck", _stick(fan))
        yield _unproven(site, fan, f"{fan}_proof_torn", _broken(fan, wire=Wire.TORN))
        counted = _proof(site, fan).tachometer
        if counted is None:
            yield _believed(site, fan)
        else:
            yield from _of_tachometer(site, fan, counted)


def _of_tachometer(site: Site, fan: str, counted: Tachometer) -> Iterator[Fault]:
    """Yield a fan that is too slow, a line shorted to ground or noisy, and speeds at the limits."""
    slow, fast = (each / counted.speed_rpm for each in (counted.slowest_rpm, counted.fastest_rpm))
    too_fast_hz = counted.pulses_hz(FAST * counted.fastest_rpm)
    yield _unproven(site, fan, f"{fan}_weak", _broken(fan, pace=SLOW * slow))
    yield _unproven(site, fan, f"{fan}_proof_shorted", _broken(fan, wire=Wire.SHORTED))
    yield _unproven(site, fan, f"{fan}_proof_noisy", _broken(fan, noise_hz=too_fast_hz))
    for name, share, low in (("slow", slow, HIGHEST), ("fast", fast, 1 - HIGHEST)):
        turns = _broken(fan, noise_hz=counted.pulses_hz(share * counted.speed_rpm), low_share=low)
        yield replace(
            watched(site, f"{fan}_turns_{name}", turns, _mend(fan)), again=False, calm=True
        )


def _unproven(site: Site, fan: str, name: str, cause: Act) -> Fault:
    """Return a fan without its proof: the heater is off within two ticks, then a rule trips.

    A tachometer first counts for two windows. A rule of a measured current may trip first.
    """
    proof = _proof(site, fan)
    counting_s = 2 * proof.tachometer.window_s if proof.tachometer else 0.0
    rules = ("fan_stopped", *(CURRENT_RULES if site.facts.current else ()))
    trip = Trip(rules, site.loop.next_step_s(counting_s + proof.within_s) + TICK_S)
    found = tripping(site, name, cause, trip, _mend(fan))
    return replace(found, off_within_s=counting_s + 2 * TICK_S, again=True)


def _believed(site: Site, fan: str) -> Fault:
    """Return a fan that stands still while its contact is stuck closed: no proof shows this."""
    stuck = _stick(fan, wire=Wire.SHORTED)
    return watched(site, f"{fan}_stuck_with_its_contact", stuck, _mend(fan))


def _stick(fan: str, *, wire: Wire = Wire.SOUND) -> Act:
    def cause(world: World) -> None:
        world.wiring.heat[fan] = effects.OPENED  # the fan moves no air
        world.device.proofs[fan].fail(stands=True, wire=wire)

    return cause


def _broken(fan: str, **how: Any) -> Act:
    return lambda world: world.device.proofs[fan].fail(**how)


def _proof(site: Site, fan: str) -> Proof:
    proof = site.controller.outputs[fan].proof
    assert proof is not None  # noqa: S101 - the fan has a proof
    return proof


def _mend(fan: str) -> Act:
    def cure(world: World) -> None:
        world.wiring.heat.pop(fan, None)
        world.device.proofs[fan].fail()

    return cure
