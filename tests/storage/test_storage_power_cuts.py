"""Ten thousand power cuts on the kilns' binaries, while they fire, are ordered about and save."""

from collections import Counter
from itertools import islice
from random import Random
from typing import NamedTuple

import pytest
from storage_firing import Firing, FiringByKeys, machine
from storage_format import PROGRESS_BYTES, Progress
from storage_verdict import FIRST_STEP_S, Again, Judge, Outcome
from suite import amount

from heatwright.sim.binary.elf import Elf
from heatwright.sim.faults.bounds import checks_s
from heatwright.spec import Controller
from heatwright.spec.board.eeprom import start_s

SEEDS = range(24)
CUTS = amount("power_cuts") // len(SEEDS)
"""In each of the firings."""
MOST_ROWS = 20_000
RESOLUTION_S = 0.0002
CHANGES_K = (0.0, 20.0, -20.0, 45.0, -45.0)
"""Of the machine while the power is away: within 30 K, where it goes on, or beyond."""
COMMON, RARE = (
    {"torn", "idle", "goes on"},
    {"cold", "unreadable", "failed", "interrupted", "paused"},
)
ENOUGH = 400
"""Cuts in a firing, and it comes by all that is common and something of what is rare."""


def kind_of(outcome: Outcome) -> str:
    by_end = {3: "failed", 4: "cold", 5: "unreadable"}
    names = {
        (0, False): by_end.get(outcome.ended, "idle"),
        (2, True): "paused",
        (5, True): "interrupted",
    }
    return names.get((outcome.state, outcome.goes_on is not None), "goes on")


class Kiln(NamedTuple):
    controller: Controller
    program: Elf
    judge: Judge
    firing: type[Firing]


@pytest.fixture(scope="session")
def kilns() -> list[Kiln]:
    """The kiln that stops when it is too cold, one that is paused, and the one with keys, whose
    programs a fault ends; those of the others it interrupts."""
    made = [machine(), machine(otherwise="pause"), machine("kiln_uno")]
    touched, pausing, keyed = (
        Kiln(*each, Judge(*each), firing)
        for each, firing in zip(made, (Firing, Firing, FiringByKeys), strict=True)
    )
    return [touched, touched, pausing, keyed]


@pytest.mark.parametrize("seed", SEEDS)
def test_every_cut_leaves_what_can_go_on_or_has_ended(kilns, seed):
    random, found = Random(seed), []  # noqa: S311
    controller, program, judge, firing_of = kilns[seed % len(kilns)]
    firing = firing_of(controller, program, seed, judge.book.record)
    # Most of them while something is written, the others as it comes.
    cuts = list(islice(firing.cuts(MOST_ROWS, busy=1.0, quiet=0.02), CUTS))
    assert len(cuts) == CUTS
    if firing_of is Firing:  # who plays with keys may change a program
        assert judge.book.forgotten(cuts, firing.edits) == ""
    tally: Counter[str] = Counter()
    for cut in cuts:
        problems = judge.problems(cut, random.choice(CHANGES_K))
        found += [f"{cut.time_s:.6f} s: {problem}" for problem in problems]
        tally[kind_of(judge.wanted)] += 1
        tally["torn"] += cut.torn
    assert found == []
    seen = set(+tally)
    assert CUTS < ENOUGH or (seen >= COMMON and seen & RARE)


def test_the_start_takes_no_longer_than_the_watchdog_is_told(kilns):
    """Every slot is written, so that each must be looked at: the first step comes so much later."""
    controller, program, judge, _ = kilns[0]
    memory = judge.book.memory
    record = Progress(0, 1, 1, 1, 0, 20.0, 20.0, 20.0, 20.0, 0, 0, 0, 0)
    slots = [
        (memory.progress_at + slot * PROGRESS_BYTES, memory.progress_slot(slot + 1, record))
        for slot in range(memory.progress_slots)
    ]
    device = Again(controller, program)
    for image in (memory.blank, memory.with_at(memory.blank, *slots)):
        device.power_up(image, 20.0)
        device.run(FIRST_STEP_S)
        while device.read("loop_chamber.steps") == 0:
            device.run(RESOLUTION_S)
        assert device.avr.time_s - FIRST_STEP_S < start_s(controller) + checks_s(
            controller, program
        )
