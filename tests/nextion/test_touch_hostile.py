"""Whatever comes from the display, nothing is read or written where it must not be.

AddressSanitizer watches every array, UndefinedBehaviorSanitizer every number.
"""

import random
from pathlib import Path

import pytest
from display_orders import Grammar, Malice, noise
from hosted_kiln import TOUCHED, flooded, ordered, run, script

BYTES = 1_000_000
ORDERS = 10_000
PER_RUN = 500


@pytest.mark.parametrize("seed", range(4))
def test_a_million_random_bytes(hosted: Path, seed: int) -> None:
    """In four runs: idle, heating, with a program, with a fault."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    begins = ("2 s", "2 s; order 2 1; 2 s", "2 s; order 8 1; 2 s", "2 s; fault 6; 2 s")[seed]
    run(hosted, begins, flooded(noise(chance, BYTES // 4)), "2 s")


def test_ten_thousand_malformed_orders(hosted: Path) -> None:
    """None of them changes anything that an order can change."""
    malice = Malice(Grammar(TOUCHED), seed=5)
    for _ in range(ORDERS // PER_RUN):
        bad = list(malice.orders(PER_RUN))
        # The `;` ends what one has left open: the next must not make an order of it.
        sent = [flooded(data + b"\n;") + script("3 ticks; look") for data in bad]
        said = run(hosted, "2 s; look", *sent, "1 s")
        first = said.states[0]
        for data, state in zip(bad, said.states[1:], strict=False):
            assert state == first, data


def test_sound_orders_among_noise_are_still_heard(hosted: Path) -> None:
    chance = random.Random(6)  # noqa: S311
    for _ in range(20):
        loud = noise(chance, 2000).replace(b"#", b"")
        said = run(hosted, "2 s", flooded(loud), "5 ticks; order 3 777; 5 ticks")
        assert said.state["setpoint"] == "777"


def test_a_flood_of_sound_orders_is_taken_one_by_one(hosted: Path) -> None:
    """One in a tick; what the ring has no room for is lost whole."""
    flood = ordered(*(f"3 {number}" for number in range(100, 1100)))
    said = run(hosted, "2 s", flood, "5 s")
    assert 100 <= float(said.state["setpoint"]) < 160
