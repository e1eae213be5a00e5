"""The log by itself: every row, every command, every cut of the power."""

import random
from collections.abc import Callable

import pytest
from log_course import (
    EEPROM,
    RAM,
    SLOW_RAM,
    busy_problem,
    commands_problem,
    course_problem,
    kept_problem,
    no_reading_problem,
    slow_problem,
)
from log_firmware import LogBoard, program

BOARDS = {
    "uno": RAM,
    "mega2560": RAM + ", port: 1",
    "mega2560 ": RAM + ", port: 3, baud: 9600",
    "atmega32": RAM,
    "uno ": EEPROM,
    "atmega32 ": EEPROM,
}


@pytest.mark.parametrize("board", BOARDS)
def test_on_every_board(board: str) -> None:
    assert course_problem(LogBoard(program(BOARDS[board], board.strip()))) == ""


@pytest.mark.parametrize(
    ("said", "problem"),
    [
        (RAM, no_reading_problem),
        (EEPROM, no_reading_problem),
        (SLOW_RAM, commands_problem),  # so slow that none is noted meanwhile
        (EEPROM, commands_problem),
    ],
)
def test_before_a_reading_and_any_command(said: str, problem: Callable[[LogBoard], str]) -> None:
    assert problem(LogBoard(program(said))) == ""


@pytest.mark.parametrize("problem", [slow_problem, busy_problem, kept_problem])
def test_a_slow_line_a_busy_memory_and_a_loss_of_power(problem: Callable[[], str]) -> None:
    assert problem() == ""


@pytest.mark.parametrize("said", [RAM, EEPROM])
def test_a_flood_of_anything_misses_no_tick(said: str) -> None:
    bench = LogBoard(program(said))
    drawn = random.Random(1)  # noqa: S311 - no secret
    begun_s, passes = bench.avr.time_s, int(bench.get("passes"))
    words = [b"log\n", b"clear\n", b"help\n", b"\r", b"\n", b"\0", b"\xff"]
    while bench.avr.time_s < begun_s + 10:
        noise = bytes(drawn.randrange(256) for _ in range(500))
        bench.computer.send_bytes(b"".join([noise, *drawn.choices(words, k=20)]))
        bench.run(0.05)
    bench.run(1.0)
    ticks = round((bench.avr.time_s - begun_s) / 0.01)
    assert int(bench.get("passes")) - passes == ticks
    bench.ask("clear")
    bench.ask("")
    assert bench.ask("help")[0].startswith("log")
