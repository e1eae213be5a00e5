"""Fans that must prove that they turn: they stand still, and what says so breaks."""

from __future__ import annotations

from collections.abc import Iterator

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bounds import TICK_S
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.readings import CURRENT_RULES
from heatwright.sim.faults.world import Site, World
from heatwright.sim.native.relay import Wire
from heatwright.spec import proven_in


def faults(site: Site) -> Iterator[Fault]:
    """Yield what can happen to the fans whose proof is judged in the loop's steps."""
    for fan in proven_in(site.controller, site.loop_name):
        yield _unproven(site, fan, f"{fan}_stuck", _stick(fan))
        yield _unproven(site, fan, f"{fan}_proof_torn", _wire(fan, Wire.TORN))
        yield _believed(site, fan)


def _unproven(site: Site, fan: str, name: str, cause: Act) -> Fault:
    """Nothing proves that it turns: no heat within two ticks, then a fault.

    A heater whose current is measured has none then, which may be told sooner.
    """
    proof = site.controller.outputs[fan].proof  # type: ignore[union-attr]
    assert proof is not None  # noqa: S101 - it has one
    measured = getattr(site.controller.outputs[site.loop.heater], "current", None)
    rules = ("fan_stopped", *(CURRENT_RULES if measured else ()))
    return Fault(
        name,
        lambda: starts.heating(site),
        cause,
        _mend(fan),
        trip=Trip(rules, proof.within_s + site.loop.period_s + TICK_S),
        off_within_s=2 * TICK_S,
        again=True,
    )


def _believed(site: Site, fan: str) -> Fault:
    """A contact that is closed for ever, and then a fan that stands still: nobody can know."""

    def cause(world: World) -> None:
        world.wiring.heat[fan] = effects.opened
        world.device.proofs[fan].fail(stands=True, wire=Wire.SHORTED)

    return Fault(
        f"{fan}_stuck_with_its_contact",
        lambda: starts.heating(site),
        cause,
        _mend(fan),
        watch_s=watch_s(site),
        again=True,
    )


def _stick(fan: str) -> Act:
    def cause(world: World) -> None:
        world.wiring.heat[fan] = effects.opened  # it moves no air
        world.device.proofs[fan].fail(stands=True)

    return cause


def _wire(fan: str, wire: Wire) -> Act:
    return lambda world: world.device.proofs[fan].fail(wire=wire)


def _mend(fan: str) -> Act:
    def cure(world: World) -> None:
        world.wiring.heat.pop(fan, None)
        world.device.proofs[fan].fail()

    return cure
