"""What `heatwright verify` looks at, in this process, with all or some faults."""

from collections.abc import Callable, Collection, Iterator
from typing import NamedTuple

from suite import drawn

from heatwright.cli.firmware import build_firmware
from heatwright.cli.fits import DoesNotFit
from heatwright.cli.verify.checks import chain_checks, replay_checks, run_checks
from heatwright.cli.verify.trials import closed_loop
from heatwright.sim.binary.elf import Elf
from heatwright.sim.chain import chain_errors
from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.rehearsal import findings, parts, rehearse
from heatwright.sim.timing import measure
from heatwright.spec import Spec
from heatwright.spec.checks.finding import Finding


class Verdict(NamedTuple):
    """What was found of a spec.

    fits -- whether its board has room for its firmware; tried -- the checks and faults that were
    looked at, by name; red -- those that failed: name and detail.
    """

    fits: bool
    tried: tuple[str, ...] = ()
    red: tuple[tuple[str, str], ...] = ()


class Silent:
    def __call__(self, done: float, total: float) -> None:
        pass

    def note(self, text: str) -> None:
        pass

    def end(self, text: str = "") -> None:
        pass


def rehearsed(spec: Spec) -> tuple[Finding, ...]:
    """Return what `heatwright check` finds when it runs the machine."""
    found = [rehearse(spec.controller, part, Silent()) for part in parts(spec.controller)]
    return findings(spec.controller, [each for tripped in found for each in tripped])


def verified(
    spec: Spec,
    faults: int | Collection[str] | None = None,
    told: Callable[[str], object] = lambda _: None,
) -> Verdict:
    """Build the spec's firmware and try it.

    faults -- how many of the catalogue's are tried, always the same ones, or their ids; None: all
    of them; told -- is given a line for each.
    """
    tried, red = [], []
    try:
        for name, detail in _findings(spec, faults):
            tried.append(name)
            red += [(name, detail)] if detail else []
            told(f"{'red  ' if detail else 'green'} {name} {detail}")
    except DoesNotFit:
        return Verdict(fits=False)
    return Verdict(True, tuple(tried), tuple(red))


def _findings(spec: Spec, faults: int | Collection[str] | None) -> Iterator[tuple[str, str]]:
    controller = spec.controller
    built = build_firmware(spec, Silent())
    elf = built.elf
    loops = closed_loop(controller, elf, Silent())
    checks = (
        *chain_checks(chain_errors(controller, elf)),
        *replay_checks(loops),
        *run_checks(loops, controller.simulated),
    )
    for check in checks:
        yield check.what, "" if check.passed else f"{check.found}, not {check.limit}"
    timing = measure(controller, elf, static_stack_bytes=built.stack_bytes)
    for name, figure in timing.figures.items():
        yield name, "" if figure.passed else f"{figure.worst}, not {figure.limit}"
    by_name = {fault.id: fault for fault in catalogue(controller, Elf(elf))}
    for name in _chosen(spec, list(by_name), faults):
        yield name, try_fault(by_name[name]).detail


def _chosen(spec: Spec, names: list[str], faults: int | Collection[str] | None) -> list[str]:
    if faults is None:
        return names
    if not isinstance(faults, int):
        return [name for name in names if name in faults]
    own = {f"{spec.digest} {name}": name for name in names}  # others for each spec
    chosen = drawn(list(own), min(1.0, faults / len(own))) if faults else set()
    return [name for key, name in own.items() if key in chosen]
