"""The slave's C on this computer: against the oracle, and case by case what happens on its line:
bytes, flags, silences, and what follows."""

import struct
from pathlib import Path
from typing import NamedTuple

import pytest
from modbus_host import ADDRESS, frame, fuzz, played, received, run, slave_world, ticks
from suite import amount

from heatwright.sim.interfaces.modbus_frames import framed

SEEDS = 4
PARITY, OVERRUN, FRAMING = 1 << 2, 1 << 3, 1 << 4
SILENCE, MAIN, MAIN_ALONE, STATE = b"q", b"m", b"M", b"s"

ASK = framed(ADDRESS, bytes.fromhex("04 0000 0001"))
ANSWER = framed(ADDRESS, bytes.fromhex("04 02 0001"))
WRITE = framed(ADDRESS, struct.pack(">BHH", 6, 100, 300))
TO_ALL = framed(0, struct.pack(">BHH", 6, 100, 300))


def flagged(flags: int, byte: int) -> bytes:
    """A byte with the receiver's flags."""
    return b"x" + bytes([flags, byte])


def leaves(count: int) -> bytes:
    """So many bytes of the answer leave."""
    return b"p" + bytes([count])


class Case(NamedTuple):
    """sent -- for each of `frame` and MAIN; counters -- messages, errors, exceptions, requests,
    unanswered, overruns."""

    name: str
    script: tuple[bytes, ...]
    sent: tuple[bytes, ...]
    counters: tuple[int, ...]


CASES = [
    Case("no_silence", (received(ASK), MAIN), (b"",), (0, 0, 0, 0, 0, 0)),
    Case("silence", (received(ASK), SILENCE, MAIN), (ANSWER,), (1, 0, 0, 1, 0, 0)),
    Case("two_in_one", (frame(ASK + ASK),), (b"",), (0, 1, 0, 0, 0, 0)),
    Case("longest_foreign", (frame(framed(9, bytes(253))), frame(ASK)), (b"", ANSWER),
         (2, 0, 0, 1, 0, 0)),
    Case("too_long_foreign", (frame(framed(9, bytes(254))), frame(ASK)), (b"", ANSWER),
         (1, 1, 0, 1, 0, 0)),
    *(
        Case(f"{name}_at_{place}",
             (received(ASK[:place]), flagged(flag, ASK[place]), received(ASK[place + 1 :]),
              SILENCE, MAIN, frame(ASK)),
             (b"", ANSWER), (1, 1, 0, 1, 0, int(flag == OVERRUN)))
        for name, flag in (("parity", PARITY), ("overrun", OVERRUN), ("framing", FRAMING))
        for place in (0, 5, 7)
    ),
    Case("while_it_is_asked",
         (received(WRITE), SILENCE, received(ASK), SILENCE, MAIN, frame(ASK)),
         (WRITE, ANSWER), (2, 0, 0, 2, 0, 0)),
    Case("while_to_all_waits",
         (received(TO_ALL), SILENCE, received(ASK[:3]), MAIN, received(ASK[3:]), SILENCE, MAIN,
          frame(ASK)),
         (b"", b"", ANSWER), (2, 1, 0, 2, 1, 0)),
    Case("while_it_answers",
         (received(WRITE), SILENCE, MAIN_ALONE, leaves(3), received(ASK), SILENCE, MAIN,
          frame(ASK)),
         (WRITE, ANSWER), (2, 0, 0, 2, 0, 0)),
    Case("silence_while_it_answers",
         (received(WRITE), SILENCE, received(ASK[:1]), MAIN_ALONE, leaves(3), SILENCE, MAIN,
          frame(ASK)),
         (WRITE, ANSWER), (2, 0, 0, 2, 0, 0)),
    Case("damaged_while_asked",
         (received(WRITE), SILENCE, flagged(OVERRUN, 1), SILENCE, MAIN, frame(ASK)),
         (WRITE, ANSWER), (2, 0, 0, 2, 0, 0)),
    Case("noise_behind_a_frame", (received(WRITE), flagged(FRAMING, 0), SILENCE, MAIN, frame(ASK)),
         (b"", ANSWER), (1, 1, 0, 1, 0, 0)),
    Case("damage_after_overrun",
         (flagged(OVERRUN, 1), SILENCE, flagged(PARITY, 1), SILENCE, frame(ASK)),
         (ANSWER,), (1, 2, 0, 1, 0, 1)),
    Case("ticks", (ticks(7), frame(ASK), ticks(5)), (ANSWER,), (1, 0, 0, 1, 0, 0)),
]  # fmt: skip


@pytest.fixture(scope="session")
def slave() -> Path:
    """The slave as a program of this computer: see modbus_host."""
    return slave_world().sanitized().program()


@pytest.mark.parametrize("seed", range(SEEDS))
def test_it_answers_as_documented(slave: Path, seed: int) -> None:
    assert played(slave, fuzz(seed, amount("modbus_frames_host") // SEEDS)) == ""


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_line(slave: Path, case: Case) -> None:
    state, *sent, last = run(slave, [STATE, *case.script, STATE])
    assert tuple(sent) == case.sent
    *counters, silent_ticks, _ = map(int, last.split()[15:])
    assert tuple(counters[1:]) == case.counters
    assert silent_ticks == (5 if case.name == "ticks" else 0)
    if not any(WRITE in part or TO_ALL in part for part in case.script):
        assert last.split()[:15] == state.split()[:15]


def test_a_silence_is_counted_to_its_largest_number_and_no_further(slave: Path) -> None:
    (state,) = run(slave, [ticks(60_000), ticks(60_000), STATE])
    assert state.split()[-2:] == [b"65535", b"0"]


def test_the_line_is_set_up(slave: Path) -> None:
    """1200 baud of 16 MHz with U2X (1666 + 1 eighths), 8O1, timer 2 at clock / 1024 and nothing
    else, the receiver's pin an input that is pulled up."""
    assert run(slave, [b"l"]) == [bytes((0x82, 0x06, 2, 0x36, 0, 7, 1, 0))]
