"""The log by itself: every row, every command, every cut of the power; its lines broken in turn."""

import random

import pytest
from log_course import EEPROM, RAM, Judge, course_problem, eeprom_problem, ram_problem
from log_firmware import Broken, LogBoard

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
    assert course_problem(LogBoard(board.strip(), BOARDS[board])) == ""


@pytest.mark.parametrize("judge", [ram_problem, eeprom_problem])
def test_nothing_is_wrong_with_the_whole(judge: Judge) -> None:
    assert judge(None) == ""


@pytest.mark.parametrize("said", [RAM, EEPROM])
def test_a_flood_of_anything_misses_no_tick(said: str) -> None:
    bench = LogBoard("uno", said)
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


LOG = [
    Broken("log_talk.c", "place > decimals", "place >= decimals"),
    Broken("log_talk.c", "text[size++] = '.';", ""),
    Broken("log_talk.c", "text[0] = '-';", "text[0] = '+';"),
    Broken("log_talk.c", "1u + put_number(text + 1", "put_number(text + 1"),
    Broken("log_talk.c", "next + 1u) * LOG_EVERY_S", "next) * LOG_EVERY_S"),
    Broken("log_talk.c", "entry->temperature_dc != LOG_NO_READING", "true"),
    Broken("log_talk.c", "            words = 0;", ""),
    Broken("log_talk.c", "        words++;", ""),
    Broken("log_talk.c", "size < LOG_PORT_SIZE", "size < LOG_PORT_SIZE + 1"),
    Broken("log_talk.c", "next = log_ring_first(); /*", "; /*"),
    Broken("log_talk.c", "        words = END;", ""),
    Broken("log_talk.c", "        sending = false;\n        words = END;", "        words = END;"),
    Broken("log_talk.c", "    next++;", ""),
    Broken("log_talk.c", "    sending = false;\n    if (unreadable)", "    if (unreadable)"),
    Broken("log_talk.c", "if (unreadable) {", "if (false) {"),
    Broken("log_talk.c", "        next = 0;", ""),
    Broken("log_talk.c", "        log_ring_clear();", ""),
    Broken("log_talk.c", "        log_begin_anew();", ""),
    Broken("log.c", "{\n    ticks = 0;", "{"),
    Broken("log_talk.c", "if (length != 0 || unreadable) {", "if (true) {"),
    Broken("log_talk.c", "length != 0 || unreadable", "length != 0"),
    Broken("log_talk.c", "command[length] = '\\0';", ""),
    Broken("log_talk.c", "        length = 0;\n        unreadable", "        unreadable"),
    Broken("log_talk.c", "        unreadable = false;", ""),
    Broken("log_talk.c", "byte == LOG_PORT_DAMAGED || ", ""),
    Broken("log_talk.c", "|| length == COMMAND_SIZE", ""),
    Broken("log_note.c", "if (!(tenths > -32767.0f)) {", "if (false) {"),
    Broken("log_note.c", "if (tenths > 32767.0f) {", "if (false) {"),
    Broken("log_note.c", "tenths < 0.0f ? tenths - 0.5f : tenths + 0.5f", "tenths + 0.5f"),
    Broken("log_note.c", "tenths < 0.0f ? tenths - 0.5f : tenths + 0.5f", "tenths"),
    Broken("log_note.c", "loop_air.has_reading && ", ""),
    Broken("log_note.c", "&& loop_air.missing == 0", ""),
    Broken("log.c", "    ticks++;", "    ticks += 2;"),
    Broken("log.c", "        ticks = 0;\n        log", "        log"),
    Broken("log.c", "        log_note();", ""),
    Broken("log_talk.c", "words != 0 || sending", "sending"),
    Broken("log_talk.c", "words != 0 || sending", "words != 0"),
    Broken("log_talk.c", "words == 0 && log_port_take", "log_port_take"),
    Broken("log_talk.c", "if (!log_port_is_empty()) {", "if (false) {"),
]
PORT = [
    Broken("log_port.c", "room == 0", "false"),
    Broken("log_port.c", "intact && room > 1", "room > 1"),
    Broken("log_port.c", "intact && room > 1", "intact"),
    Broken("log_port.c", "    size = length;", ""),
    Broken("log_port.c", "    sent = 0;", ""),
    Broken("log_port.c", "    sent++;", ""),
]
IN_RAM = [
    Broken("log_ring.c", "end > LOG_ENTRIES ? end - LOG_ENTRIES : 0", "0"),
    Broken("log_ring.c", "place >= back", "place > back"),
    Broken("log_ring.c", "+ LOG_ENTRIES - back", "- back"),
    Broken("log_ring.c", "place + 1u == LOG_ENTRIES", "place == LOG_ENTRIES"),
    Broken("log_ring.c", "    end++;", ""),
    Broken("log_ring.c", "    end = 0;", ""),
]
IN_EEPROM = [
    Broken("log_ring.c", "into->lap_low == into->lap_low_again", "true"),
    Broken("log_ring.c", "into->digest == (uint8_t)SPEC_DIGEST", "true"),
    Broken("log_ring.c", "        place = 0;\n        lap++;", "        place = 0;"),
    Broken("log_ring.c", "place == LOG_ENTRIES", "place > LOG_ENTRIES"),
    Broken("log_ring.c", "(lap_of(&slot) - lap) >= 0", "(lap_of(&slot) - lap) > 0"),
    Broken("log_ring.c", "            place = i;", ""),
    Broken("log_ring.c", "            lap = lap_of(&slot);", ""),
    Broken("log_ring.c", "if (found) {\n        go_on();", "if (false) {\n        go_on();"),
    Broken("log_ring.c", "if (found) {\n        go_on();", "if (true) {\n        go_on();"),
    Broken("log_ring.c", "lap == 0 ? 0 : log_ring_end() - LOG_ENTRIES", "0"),
    Broken("log_ring.c", "return eeprom_is_ready();", "return true;"),
    Broken("log_ring.c", "|| lap_of(&slot) != number / LOG_ENTRIES", ""),
    Broken("log_ring.c", "    writing.lap_low = (uint8_t)lap;", ""),
    Broken("log_ring.c", "    writing.digest = (uint8_t)SPEC_DIGEST;", ""),
    Broken("log_ring.c", "    writing.lap_low_again = (uint8_t)lap;", ""),
    Broken("log_ring.c", "    to_forget = LOG_ENTRIES;", ""),
    Broken("log_ring.c", "    to_forget--;", ""),
    Broken("log_ring.c", "(uint8_t)~slot.lap_low", "slot.lap_low"),
    Broken("log_ring.c", "        next_byte++;", ""),
    Broken("log_ring.c", "sizeof writing) {\n            go_on();", "0) {\n            go_on();"),
]


@pytest.mark.parametrize(
    ("judge", "broken"),
    [
        *((ram_problem, each) for each in (*LOG, *PORT, *IN_RAM)),
        *((eeprom_problem, each) for each in IN_EEPROM),
    ],
    ids=lambda each: f"{each.right[:40]} -> {each.wrong[:40]}" if isinstance(each, Broken) else "",
)
def test_what_is_broken_is_seen(judge: Judge, broken: Broken) -> None:
    assert judge(broken) != ""
