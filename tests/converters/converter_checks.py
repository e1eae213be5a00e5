"""What a converter's answers are, after its data sheet, and what a firmware makes of them.

Status and raw reading of each step; what is not valid leaves the reading as it was.
"""

from collections.abc import Callable, Iterable
from random import Random

import numpy as np
from rig.chips import Crucible

VALID, NO_ANSWER, SHORT, CRC, STALE, RESET, OPEN, RANGE = 0, 1, 2, 3, 4, 5, 17, 18
STEPS_PER_K = {"max6675": 4, "max31855": 4, "max31856": 128}
ENDS_C = {"max6675": (0.25, 1023.75), "max31855": (-270.0, 1372.0), "max31856": (-199.9, 1371.9)}
Judged = Callable[[int], tuple[int, int]]


def reading_problem(bench: Crucible, count: int) -> str:
    """Take temperatures over the range: each is the nearest code, in the next step but one."""
    kind = bench.controller.sensors["tip"].kind
    bench.steps()
    for celsius in np.linspace(*ENDS_C[kind], count):
        bench.sense(float(celsius))
        step = bench.steps(2)[-1]
        due = np.floor(STEPS_PER_K[kind] * celsius + 0.5)
        if step["reading_status"] != VALID or step["reading_raw"] != due:
            return f"{celsius} °C are {step['reading_raw']}, status {step['reading_status']}"
        if step["temperature_c"] != np.float32(due / STEPS_PER_K[kind]):
            return f"{due} steps are {step['temperature_c']} °C"
    return ""


def judged_6675(word: int) -> tuple[int, int]:
    body = word >> 1
    if body in {0, 0x7FFF}:
        return NO_ANSWER, 0
    if word >> 15 or word >> 1 & 1:
        return CRC, 0
    return (OPEN, 0) if word >> 2 & 1 else (VALID, word >> 3)


def judged_31855(word: int) -> tuple[int, int]:
    if word in {0, 0xFFFFFFFF}:
        return NO_ANSWER, 0
    fault, reasons = word >> 16 & 1, word & 7
    if word >> 17 & 1 or word >> 3 & 1 or bool(fault) != bool(reasons):
        return CRC, 0
    if fault:
        return (OPEN if reasons & 1 else SHORT), 0
    raw = word >> 18
    return VALID, raw - (1 << 14) if raw >> 13 else raw


ANSWERS: dict[str, tuple[Judged, int, tuple[int, ...]]] = {
    "max6675": (judged_6675, 16, (15, 2, 1)),
    "max31855": (judged_31855, 32, (17, 16, 3, 2, 1, 0)),
}
"""Who judges a chip's answer, its bits, and those that are zero in most."""


def words(chance: Random, bits: int, often_zero: tuple[int, ...], count: int) -> list[int]:
    """Draw any word, and more of those that are almost good; all ones and zeros, and every bit."""
    mask = ~sum(1 << bit for bit in often_zero)
    drawn = [chance.getrandbits(bits) for _ in range(count)]
    good = [word & mask for word in drawn]
    flipped = [word ^ 1 << chance.choice(often_zero) for word in good]
    full = (1 << bits) - 1
    edges = [0, 1, 2, full, full - 1, full ^ 1 << (bits - 1), 1 << (bits - 1)]
    alone = [400 << bits - 14 | 1 << bit for bit in often_zero]
    return [*edges, *alone, *drawn, *good, *flipped]


def answers_problem(bench: Crucible, answers: Iterable[int], judged: Judged) -> str:
    _, raw = bench.read(2)[-1]
    for word in answers:
        status, code = judged(word)
        raw = raw if status else code
        if (found := bench.answered(word)) != (status, raw):
            return f"{word:#x} is {found}, not {(status, raw)}"
    return ""


def short_problem(bench: Crucible) -> str:
    bench.sense(100.0)
    bench.steps(3)
    bench.chip.short("low")
    if bench.statuses(2) != [SHORT, SHORT]:
        return "a short of its answers"
    bench.chip.short(None)
    if bench.statuses(3)[1:] != [VALID, VALID]:
        return "after a short"
    bench.chip.unplug()
    return "" if bench.statuses(3)[-1] in {NO_ANSWER, STALE} else "a chip that is not there"


SETTINGS = bytes.fromhex("91 03 FF 7F C0 7F FF 80 00 00")
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
"""CR0 to CJTO as they should be: automatic, with the open test, 50 Hz; type K, no averaging."""
LATE = bytes.fromhex("80 07 00 01 02 03 04 05 06 07")
"""What an earlier firmware may have left: it converts, filters 60 Hz, takes its wire for type T."""
CR1, CJTO, CJTL, LTCBH, LTCBL, SR = 1, 9, 11, 12, 14, 15
SHORTEST_S = 0.31
"""The period after which, behind a set-up, no reading is in time for the next step."""


def judged_31856(registers: bytes) -> tuple[int, int]:
    if len(set(registers)) == 1 and registers[0] in {0, 0xFF}:
        return NO_ANSWER, 0
    if registers[: CJTO + 1] != SETTINGS:
        return (RESET if registers[: CJTO + 1] == POWER_ON[: CJTO + 1] else CRC), 0
    said = bytearray(registers[CJTO + 1 :])
    said[CJTL - CJTO - 1] &= 0xFC
    said[LTCBL - CJTO - 1] &= 0xE0
    if not any(said):
        return NO_ANSWER, 0
    for bits, status in ((0x02, SHORT), (0x01, OPEN), (0xC0, RANGE)):
        if registers[SR] & bits:
            return status, 0
    return VALID, int.from_bytes(registers[LTCBH:SR], "big", signed=True) >> 5


def registers_said(count: int) -> list[bytes]:
    """Return answers of each sort, then any, and more of those that are almost good."""
    said = ("19 00 01 40 00 01", "19 00 01 40 00 41", "19 00 01 40 00 40", "19 00 01 40 00 80",
            "19 00 01 40 00 03", "19 00 00 00 00 00", "00 00 00 01 40 00", "00 04 00 00 00 00",
            "00 00 00 00 20 00", "19 03 01 40 1F 00", "00 00 00 00 00 00",
            "00 03 00 00 1F 00", "19 00 FF FF E0 00")  # fmt: skip
    found = [SETTINGS + bytes.fromhex(each) for each in said]
    found += [bytes(16), b"\xff" * 16, POWER_ON, SETTINGS[:9] + b"\x01" + found[0][10:]]
    found += [POWER_ON[:9] + b"\x01" + POWER_ON[10:], POWER_ON[:1] + b"\x13" + POWER_ON[2:]]
    found += [b"\x11" + POWER_ON[1:], b"\x01" + POWER_ON[1:], SETTINGS + POWER_ON[10:]]
    found += [SETTINGS[:1] + bytes([SETTINGS[1] ^ 1]) + SETTINGS[2:] + POWER_ON[CJTO + 1 :]]
    chance = Random(7)  # noqa: S311 - no secret
    for _ in range(count):
        drawn = bytearray(SETTINGS + chance.randbytes(6))
        drawn[SR] &= chance.choice((0x00, 0x3C, 0xFF))
        found.append(bytes(drawn))
        place = chance.choice((CR1, CJTO, CJTL, LTCBL, chance.randrange(16)))
        drawn[place] ^= 1 << chance.randrange(8)
        found += [bytes(drawn), chance.randbytes(16)]
    return found


def set_up_problem(bench: Crucible) -> str:
    """Power on beside a chip that was told otherwise: it is set up, and a reading is awaited."""
    bench.chip.was_told(LATE)
    bench.sense(30.0)
    due = [(STALE, 0), (VALID, 30 * 128), (VALID, 30 * 128)]
    if (found := bench.read(3)) != due:
        return f"first readings {found}"
    if bench.chip._registers[: len(SETTINGS)] != SETTINGS or bench.chip.orders != 2:
        return f"settings {bench.chip._registers.hex()} after {bench.chip.orders} orders"
    return "misused" if bench.chip.misused else ""


def registers_problem(bench: Crucible, answers: Iterable[bytes]) -> str:
    """Let it answer each of these once: what is set up anew is so at once, and nothing else is."""
    bench.sense(30.0)
    chip, raw, sound = bench.chip, bench.read(3)[-1][1], (VALID, 30 * 128)
    for answer in answers:
        orders = chip.orders
        status, code = judged_31856(answer)
        raw = raw if status else code
        if (found := bench.answered(int.from_bytes(answer, "big"))) != (status, raw):
            return f"{answer.hex()} is {found}, not {(status, raw)}"
        anew = status in {NO_ANSWER, RESET, CRC}
        if (found := bench.read(2)) != ([(STALE, raw), sound] if anew else [sound, sound]):
            return f"{answer.hex()}: then {found}"
        raw = sound[1]
        if chip.orders != orders + 2 * anew:
            return f"{answer.hex()}: {chip.orders - orders} orders"
    wrong = chip.port.violations or chip.misused
    return f"{chip.port.phases}, {chip.misused}" if wrong else ""
