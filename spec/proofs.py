"""Fans with a proof that they turn: which they are, and which loop's step checks it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heatwright.spec.outputs import Proof

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


def proofs(controller: Controller) -> dict[str, Proof]:
    """List the proofs of loops' fans, by output, in the order of the file."""
    fans = {loop.fan for loop in controller.loops.values()}
    return {
        name: output.proof
        for name, output in controller.outputs.items()
        if name in fans and output.proof is not None
    }


def proven_in(controller: Controller, loop: str) -> list[str]:
    """List the fans whose proof a loop's step checks: the first loop that names a fan checks it."""
    return [
        fan
        for fan in proofs(controller)
        if loop == next(name for name, each in controller.loops.items() if each.fan == fan)
    ]
