"""The checks of `verify`: each with its limit, the value found, and the verdict."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from heatwright.cli.verify.trials import ClosedLoop
from heatwright.generator.toolchain import BuildResult
from heatwright.sim.chain import CHAIN_BOUND_STEPS, TABLE_BOUND_STEPS, ChainError
from heatwright.sim.faults.controller.upsets import BAD, GUARDED, KINDS, RESULTS, Outcome
from heatwright.sim.judges.metrics import Metrics
from heatwright.sim.plots.plot_data import fault_label
from heatwright.sim.scenario import stops, unasked
from heatwright.spec import Expect, Simulation

NOT_COMPARED = ("fault.time_s",)
"""Variables of the clock, which are no result of a control step."""


@dataclass(frozen=True)
class Check:
    """One check of the evidence."""

    what: str
    limit: str
    found: str
    passed: bool


def build_checks(built: BuildResult) -> Iterator[Check]:
    """Check that the binary fits the chip."""
    free = built.ram_limit - built.ram_bytes - built.stack_bytes
    yield Check(
        "flash", f"{built.flash_limit} bytes", str(built.flash_bytes),
        built.flash_bytes <= built.flash_limit,
    )  # fmt: skip
    yield Check(
        "static RAM and worst stack", f"{built.ram_limit} bytes",
        f"{built.ram_bytes} + {built.stack_bytes}", free >= 0,
    )  # fmt: skip


def chain_checks(chains: Iterable[ChainError]) -> Iterator[Check]:
    """Compare the errors of analog sensors with the resolution of the ADC."""
    for chain in chains:
        for what, limit, found in (
            (f"error of the {chain.points}-point table", TABLE_BOUND_STEPS, chain.table_steps),
            (f"error of the {chain.measures} reading", CHAIN_BOUND_STEPS, chain.chain_steps),
        ):
            yield Check(
                f"sensor {chain.sensor}: {what}",
                f"{limit:g} ADC steps",
                f"{found:.3f} ADC steps",
                found <= limit,
            )


def replay_checks(loops: ClosedLoop) -> Iterator[Check]:
    """Compare the binary with the reference model, bit for bit."""
    for loop, result in loops.replays.items():
        yield Check(
            f"{loop}: variables equal the model's, bit for bit", "0 mismatches",
            f"{result.mismatches} in {result.ticks} steps",
            result.mismatches == 0 and not result.restored,
        )  # fmt: skip
        left = [name for name in result.unchecked if name not in NOT_COMPARED]
        yield Check(
            f"{loop}: variables that the model lacks", "none", ", ".join(left) or "none", not left
        )


def upset_checks(outcomes: Sequence[Outcome]) -> Iterator[Check]:
    """Check the effects of flipped bits by kind; those that are not guarded are only reported."""
    for kind in KINDS:
        tried = [each for each in outcomes if each.upset.kind == kind]
        if not tried:
            continue
        found, guarded = Counter(each.result for each in tried), kind in GUARDED
        told = ", ".join(f"{found[each]} {each}" for each in RESULTS if found[each])
        if bad := [str(each.upset.number) for each in tried if each.result in BAD]:
            told += f" (number {', '.join(bad)})"
        yield Check(
            f"upsets: {kind}",
            "no upset heats, is too hot or forgets a fault"
            if guarded
            else "not guarded: only reported",
            told,
            not guarded or not any(found[each] for each in BAD),
        )


def run_checks(loops: ClosedLoop, simulation: Simulation) -> Iterator[Check]:
    """Check that nothing trips, that chips keep to their data sheets, and the spec's `expect`."""
    expect = simulation.expect
    for loop, tripped in loops.run.faults.items():
        found = ", ".join(f"{fault_label(code)} at {time_s:.1f} s" for time_s, code in tripped)
        limit = "none but the stop that the scenario sends" if stops(simulation) else "none"
        passed = not unasked(simulation, tripped)
        yield Check(f"{loop}: no protection trips", limit, found or "none", passed)
    wrong = loops.run.complaints
    yield Check("chips keep to their data sheets", "none", "; ".join(wrong) or "none", not wrong)
    if expect is not None:
        for loop, figures in loops.run.figures.items():
            yield from _expected(loop, figures, expect)


def _expected(loop: str, figures: Metrics, expect: Expect) -> Iterator[Check]:
    for what, limit_k, found_k in (
        ("overshoot", expect.overshoot_k, figures.overshoot_k),
        ("steady error", expect.steady_k, figures.steady_error_k),
        ("tracking on ramps", expect.tracking_k, figures.tracking_k),
    ):
        if limit_k is not None and found_k is None:
            yield Check(f"{loop}: {what}", f"{limit_k:g} K", "no program ran", passed=False)
        elif limit_k is not None and found_k is not None:
            yield Check(f"{loop}: {what}", f"{limit_k:g} K", f"{found_k:.4g} K", found_k <= limit_k)
