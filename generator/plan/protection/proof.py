"""The proof that a fan turns: a contact in its air, or the pulses of its tachometer."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.parts import (
    Call,
    Constant,
    Group,
    Part,
    Stage,
    Symbol,
    Wiring,
    pair,
    pulled,
)
from heatwright.generator.plan.pins import label, lifted
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, Tachometer, facts_of
from heatwright.spec.board.timers import looks_in_tick

CONTACT = "a contact to ground: closed while air flows"
CLOSES = Symbol("down", "contact", "vane in its air")
TACHOMETER = "the fan's tachometer: an open collector, with 4.7 kΩ to the supply at the board"


@dataclass(frozen=True, slots=True)
class ProofNames:
    """The values for the templates of a proof, in addition to its name."""

    counted: bool
    counted_where: str


def plan_proofs(root: Source) -> list[Part]:
    """Plan the proof of each fan that has one."""
    proofs = facts_of(root.controller).proofs
    return [_proof(root.at("outputs", name, "proof"), name) for name in proofs]


def _proof(source: Source, name: str) -> Part:
    controller: Controller = source.controller
    proof = facts_of(controller).proofs[name]
    pin = controller.board.pins[proof.pin]
    fan = proof.tachometer
    told = source.named(name), ProofNames(fan is not None, source.at("tachometer").where)
    within = source.at("within").ticks(f"PROOF_{name.upper()}_TICKS", proof.within_s)
    return Part(
        files=pair(f"proof_{name}", "protection/proof", told),
        groups=(Group(f"Proof of {name}", (within, *_counts(source, name, fan))),),
        pins=(lifted(source.at("pin"), f"proof_{name}", pin, f"signal that {name} turns"),),
        start_calls=(Call(Stage.SENSE, f"proof_{name}.h", f"proof_{name}_start();"),),
        tick_calls=(Call(Stage.SENSE, f"proof_{name}.h", f"proof_{name}_tick();"),),
        wiring=(
            Wiring(label(pin), f"output `{name}`", CONTACT, (CLOSES,), ends=False)
            if fan is None
            else Wiring(
                label(pin), f"output `{name}`", TACHOMETER, (pulled("up", "4.7 kΩ"),), "tachometer"
            ),
        ),
    )


def _counts(source: Source, name: str, fan: Tachometer | None) -> tuple[Constant, ...]:
    """Bound the pulses in a window: the least at the slowest speed, the most at the fastest."""
    if fan is None:
        return ()
    prefix, at = f"PROOF_{name.upper()}", source.at("tachometer")
    slow_hz, fast_hz = fan.pulses_hz(fan.slowest_rpm), fan.pulses_hz(fan.fastest_rpm)
    least = math.floor(slow_hz * fan.window_s + 1e-9)
    most = math.ceil(fast_hz * fan.window_s - 1e-9)
    in_tick = looks_in_tick(source.controller)
    looks, each_us = fan.window_ticks * in_tick, 1000 * TICK_MS / in_tick
    slow, fast = quantity(fan.slowest_rpm, "rpm"), quantity(fan.fastest_rpm, "rpm")
    window = f"{quantity(fan.window_s, 's')}: {least} pulses at {slow}"
    return (
        at.count(f"{prefix}_WINDOW_LOOKS", looks, f"{window}, {each_us:g} us per sample"),
        at.at("minimum").count(f"{prefix}_LEAST", least, f"{slow}, {fan.pulses} per revolution"),
        at.at("maximum").count(f"{prefix}_MOST", most, f"{fast}, {fan.pulses} per revolution"),
    )
