"""Fans whose turning is proven: which they are, and which loop's step judges them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from heatwright.spec.outputs import Proof

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


def proofs(controller: Controller) -> dict[str, Proof]:
    """List what proves the fans of loops, by output, in the order of the file."""
    fans = {loop.fan for loop in controller.loops.values()}
    return {
        name: output.proof
        for name, output in controller.outputs.items()
        if name in fans and output.proof is not None
    }


def proven_in(controller: Controller, loop: str) -> list[str]:
    """List the fans whose proof is judged in the steps of a loop: the first that names them."""
    return [
        fan
        for fan in proofs(controller)
        if loop == next(name for name, each in controller.loops.items() if each.fan == fan)
    ]
