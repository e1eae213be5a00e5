"""The contact that says that a fan turns."""

from __future__ import annotations

from heatwright.generator.plan.numbers import quantity, ticks
from heatwright.generator.plan.parts import Call, File, Group, Part, Stage, Wiring
from heatwright.generator.plan.pins import label, lifted
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, proofs


def plan_proofs(root: Source) -> list[Part]:
    """Plan the proof of each fan that has one."""
    return [_proof(root.at("outputs", name, "proof"), name) for name in proofs(root.controller)]


def _proof(source: Source, name: str) -> Part:
    controller: Controller = source.controller
    proof = proofs(controller)[name]
    pin = controller.board.pins[proof.pin]
    context = {"name": name, "NAME": name.upper(), "where": source.where}
    within = source.at("within").count(
        f"PROOF_{name.upper()}_TICKS", ticks(proof.within_s), quantity(proof.within_s, "s")
    )
    return Part(
        files=tuple(
            File(f"src/proof_{name}.{end}", f"src/proof.{end}.j2", context) for end in ("h", "c")
        ),
        groups=(Group(f"Proof of {name}", (within,)),),
        pins=(lifted(source.at("pin"), f"proof_{name}", pin, f"proof that {name} turns"),),
        start_calls=(Call(Stage.SENSE, f"proof_{name}.h", f"proof_{name}_start();"),),
        wiring=(
            Wiring(label(pin), f"output `{name}`", "a contact to ground: closed while air flows"),
        ),
    )
