"""Drawn machines by number: each is the same one at any time, on any computer."""

import time
from random import Random
from typing import Any, NamedTuple

from rig.controllers import Drawn, attempt
from rig.verified import verified
from suite import SEED

from heatwright.spec import Spec, SpecError


class Machine(NamedTuple):
    """A drawn spec with a machine to try it on; refused -- what `check` told of others before it.

    Those that have no machine are passed over: there is nothing to verify.
    """

    text: str
    spec: Spec
    refused: tuple[str, ...]


def machine(number: int) -> Machine:
    """Draw one; SUITE_SEED draws others."""
    random = Random(f"machine {SEED} {number}")  # noqa: S311 - no secret
    refused: list[str] = []
    while True:
        found = attempt(random.randint)
        if isinstance(found, SpecError):
            refused.append(found.problems[0].reason)
        elif isinstance(found, Drawn) and found.spec.controller.simulation is not None:
            return Machine(found.text, found.spec, tuple(refused))


def verify(piece: tuple[int, int | None]) -> dict[str, Any]:
    """Draw one and verify it; what it raises is found, too: any of them would end a user's run."""
    number, faults = piece
    began_s = time.process_time()
    drawn = machine(number)
    found: dict[str, Any] = {
        "number": number,
        "refused": drawn.refused,
        "digest": drawn.spec.digest,
    }
    try:
        verdict = verified(drawn.spec, faults)
    except Exception as error:
        found |= {"end": "red", "red": [("raised", f"{type(error).__name__}: {error}")]}
    else:
        end = "red" if verdict.red else "verified" if verdict.fits else "does not fit"
        found |= {"end": end, "tried": len(verdict.tried), "red": verdict.red}
    return found | {"cpu_s": round(time.process_time() - began_s, 1)}
