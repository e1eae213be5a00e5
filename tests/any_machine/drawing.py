"""Machines as their owners describe them, by name; and drawn ones by number: each is the same one
at any time, on any computer."""

import re
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import yaml
from rig.controllers import Drawn, attempt
from rig.firmware import plain, put
from rig.verified import rehearsed, verified
from suite import SEED, amount

from heatwright.spec import Controller, Spec, SpecError, load_text
from heatwright.spec.checks.finding import Finding
from heatwright.spec.loading.loader import problem_of

_DOCUMENTS = Path(__file__).with_name("machines.yaml").read_text("utf-8").split("\n---\n")
MACHINES = {
    text.partition("{name: ")[2].partition(",")[0]: "heatwright: 1\n"
    + text.replace("  plant:\n", "  plant:\n    kind: thermal_network\n")
    for text in _DOCUMENTS
}
REMEDY = re.compile(r"Write \w+: (.*)")
MOST_MENDED = 6  # times that a machine takes what `check` proposes; then another one is drawn


class Machine(NamedTuple):
    """A drawn spec with a machine to try it on; refused -- what `check` told of others before it.

    told -- what `check` told of this one when it ran it, and what was written then as it proposed.
    Those that have no machine are passed over: there is nothing to verify. So are, but in the
    largest suite, those that take many minutes to simulate: with a period above a minute or below
    50 ms, or with a heater's PWM above 20 kHz, of which each edge is simulated.
    """

    text: str
    spec: Spec
    refused: tuple[str, ...]
    told: tuple[str, ...]


def machine(number: int) -> Machine:
    """Draw one; SUITE_SEED draws others."""
    return drawn_machine(Random(f"machine {SEED} {number}"), _is_tried)  # noqa: S311 - no secret


def drawn_machine(random: Random, is_tried: Callable[[Controller], bool]) -> Machine:
    """Draw until one is tried and `check` calls it good."""
    refused: list[str] = []
    while True:
        found = attempt(random.randint)
        if isinstance(found, SpecError):
            refused.append(found.problems[0].reason)
        elif isinstance(found, Drawn) and is_tried(found.spec.controller):
            told: list[str] = []
            good = _good(found.text, found.spec, told)
            if good is not None:
                return Machine(*good, tuple(refused), tuple(told))
            refused += told


def _is_tried(controller: Controller) -> bool:
    loops = controller.loops.values()
    pulses_hz = [getattr(controller.outputs[each.heater], "frequency_hz", 0.0) for each in loops]
    return (
        controller.simulation is not None
        and 1 / min(each.period_s for each in loops) <= amount("drawn_steps_per_s")
        and max(each.period_s for each in loops) <= amount("drawn_period_s")
        and max(pulses_hz) <= amount("drawn_pwm_hz")
    )


def _good(text: str, spec: Spec, told: list[str]) -> tuple[str, Spec] | None:
    """Write what `check` proposes until it calls a spec good; None: it has no proposal.

    Raises SpecError, AssertionError: a proposal is refused, or does not do.
    """
    for _ in range(MOST_MENDED):
        findings = rehearsed(spec)
        if not findings:
            return text, spec
        told += [str(problem_of(spec.tree, finding)) for finding in findings]
        try:
            text = _mended(spec, findings)
        except LookupError:
            return None
        spec = load_text(text, "drawn.yaml")
    raise AssertionError(f"check proposes numbers that do not do: {told}")


def _mended(spec: Spec, findings: Sequence[Finding]) -> str:
    """Write the numbers that are proposed. Raises LookupError: one proposes none."""
    data = plain(spec.tree.data)
    for finding in findings:
        value = REMEDY.fullmatch(finding.remedy)
        if value is None:
            raise LookupError(finding.remedy)
        put(data, ".".join(finding.path), value[1])
    return yaml.dump(data, allow_unicode=True, sort_keys=False)


def verify(piece: tuple[int, int | None], _: object) -> dict[str, Any]:
    """Draw one and verify it; what it raises is found, too: any of them would end a user's run."""
    number, faults = piece
    began_s = time.process_time()
    found: dict[str, Any] = {"number": number, "refused": (), "told": ()}
    try:
        drawn = machine(number)
        found |= {"refused": drawn.refused, "told": drawn.told, "spec": drawn.text}
        verdict = verified(drawn.spec, faults)
    except Exception as error:
        found |= {"end": "red", "red": [("raised", f"{type(error).__name__}: {error}")]}
    else:
        end = "red" if verdict.red else "verified" if verdict.fits else "does not fit"
        found |= {"end": end, "tried": len(verdict.tried), "red": verdict.red}
    return found | {"cpu_s": round(time.process_time() - began_s, 1)}
