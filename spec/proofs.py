"""Fans with a proof that they turn."""

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
