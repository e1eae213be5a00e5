"""Random faults in firings of which `on_fault: pause` holds: they go on where they were, or end."""

import pytest
from interrupted_firing import Kiln, spec_for, strike
from interrupted_oracle import Oracle
from suite import SEED, amount

from heatwright.sim.reference.programs import state as orders

KILNS = [(otherwise, seed) for otherwise in ("stop", "pause") for seed in range(4)]
EACH = amount("interrupted_firings") // len(KILNS)
RENEWED = 10  # faults of one kiln, then another one is fired
ENOUGH = 100
COMMON = {
    "stop": {"interrupted", "to 0", "to 3", "ended 2", "ended 4"},
    "pause": {"interrupted", "to 0", "to 2", "to 3", "ended 2"},
}
"""What enough faults lead to."""


def struck(
    otherwise: str, seed: int, faults: int, on_fault: str = "pause"
) -> tuple[list[str], Oracle]:
    """Let so many faults happen; return what is wrong, and who found it. The oracle knows no
    orders: it is asked here whether more firings ended as stopped than were."""
    spec = spec_for(otherwise, on_fault)
    kiln, oracle = Kiln(spec, f"{SEED} {seed}"), Oracle(spec.controller)
    wrong: list[str] = []
    done = 0
    while done < faults and not wrong:
        latched = strike(kiln)
        done += latched
        for now in kiln.seen:
            wrong += [f"{now.time_s} s: {problem}" for problem in oracle.problems(now)]
        kiln.seen.clear()
        if oracle.tally["stopped"] > kiln.stops:
            wrong.append(
                f"{kiln.stops} STOPs were given, {oracle.tally['stopped']} firings ended so"
            )
        if kiln.dead or (latched and done % RENEWED == 0):
            kiln.renew()
            oracle.begin()
    return wrong, oracle


@pytest.mark.parametrize(("otherwise", "seed"), KILNS)
def test_a_firing_goes_on_where_it_was_or_has_ended(otherwise: str, seed: int) -> None:
    wrong, oracle = struck(otherwise, seed, EACH)
    assert wrong == []
    seen = set(+oracle.tally)
    assert EACH < ENOUGH or seen >= COMMON[otherwise]


def test_the_oracle_sees_a_firing_that_ends() -> None:
    wrong, _ = struck("stop", 0, RENEWED, on_fault="stop")
    assert wrong


def test_a_stop_that_nobody_gave_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if a firmware took what resumes a firing for what ends it."""
    given = Kiln.order

    def order(kiln: Kiln, order: int, argument: int = 0) -> None:
        given(kiln, order, argument)
        if order == orders.RESUME:
            kiln.host.order(orders.STOP)

    monkeypatch.setattr(Kiln, "order", order)
    (wrong,), _ = struck("stop", 0, RENEWED)
    assert "STOPs were given" in wrong
