"""The past of a sensor's tip, as C keeps it, against a list of all that it was told."""

import random
from types import SimpleNamespace
from typing import Any

from heatwright.sim.native.tip import BEGINS_C, Tip

KEPT = 4096  # HW_TIP_KEEPS


def test_a_tip_knows_what_it_felt_at_each_cycle_that_it_keeps() -> None:
    """Also where a value stays, and where the oldest are gone."""
    avr: Any = SimpleNamespace(cycle=0)
    tip, told = Tip(avr), [(0, BEGINS_C)]
    draw = random.Random(5)  # noqa: S311 - cases, not a secret
    for _ in range(3 * KEPT):
        avr.cycle += draw.randrange(1, 50)
        felt_c = draw.choice((told[-1][1], draw.uniform(0, 100)))
        tip.tell(felt_c)
        if felt_c != told[-1][1]:
            told.append((avr.cycle, felt_c))
    assert (tip.felt_c, tip.told_at) == (told[-1][1], avr.cycle)
    kept = told[-KEPT:]
    assert len(kept) < len(told)
    for cycle in [draw.randrange(-9, avr.cycle) for _ in range(KEPT)]:
        before = [felt_c for since, felt_c in kept if since <= cycle]
        assert tip.felt_at_c(cycle) == (before[-1] if before else kept[0][1])
