"""Whatever comes from the display, nothing is read or written where it must not be.

AddressSanitizer watches every array, UndefinedBehaviorSanitizer every number.
"""

import random
from pathlib import Path

import pytest
from touch_kiln import LOOK, fault, flooded, received, run, seconds, ticks
from touch_noise import malformed, noise

BYTES = 1_000_000
ORDERS = 10_000
PER_RUN = 500


@pytest.mark.parametrize("seed", range(4))
def test_a_million_random_bytes(kiln: Path, seed: int) -> None:
    """In four runs: idle, heating, with a program, with a fault."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    begins = (b"", received(b"#2 1;"), received(b"#8 1;"), fault(6))[seed]
    run(kiln, seconds(2), begins, seconds(2), flooded(noise(chance, BYTES // 4)), seconds(2))


def test_ten_thousand_malformed_orders(kiln: Path) -> None:
    """None of them changes anything that an order can change."""
    chance = random.Random(5)  # noqa: S311
    for _ in range(ORDERS // PER_RUN):
        bad = [malformed(chance) for _ in range(PER_RUN)]
        # The `;` ends what one has left open: the next must not make an order of it.
        script = [flooded(data + b"\n;") + ticks(3) + LOOK for data in bad]
        said = run(kiln, seconds(2), LOOK, *script, seconds(1))
        first = said.states[0]
        for data, state in zip(bad, said.states[1:], strict=False):
            assert state == first, data


def test_sound_orders_among_noise_are_still_heard(kiln: Path) -> None:
    chance = random.Random(6)  # noqa: S311
    for _ in range(20):
        loud = bytes(byte for byte in noise(chance, 2000) if byte not in b"#")
        said = run(kiln, seconds(2), flooded(loud), ticks(5), received(b"#3 777;"), ticks(5))
        assert said.state["setpoint"] == "777"


def test_a_flood_of_sound_orders_is_taken_one_by_one(kiln: Path) -> None:
    """One in a tick; what the ring has no room for is lost whole."""
    flood = b"".join(f"#3 {number};".encode() for number in range(100, 1100))
    said = run(kiln, seconds(2), received(flood), seconds(5))
    assert 100 <= float(said.state["setpoint"]) < 160
