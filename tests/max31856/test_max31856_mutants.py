"""The C of sensor and wires, broken in one place at a time: each time something has to see it."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from max31856_specs import spec_of

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.sensors.max31856 import Max31856

PERIOD_S, SHORT_PERIOD = 0.31, "310 ms"
"""The shortest: after a set-up no reading is in time for the next step."""
VALID, NO_ANSWER, SHORT, CRC, STALE, RESET, OPEN, RANGE = 0, 1, 2, 3, 4, 5, 17, 18
SETTINGS = bytes.fromhex("91 03 FF 7F C0 7F FF 80 00 00")
POWER_ON = bytes.fromhex("00 03 FF 7F C0 7F FF 80 00 00 00 00 00 00 00 00")
LATE = bytes.fromhex("80 07 00 01 02 03 04 05 06 07")
"""What an earlier firmware may have left: it converts, filters 60 Hz, takes its wire for type T."""
JUNCTION = bytes([25, 0])
SENSOR, WIRES = "src/sensor_tip.c", "src/spi_tip.c"
MUTANTS = [
    (SENSOR, "    ticks_left = SENSOR_TIP_PERIOD_TICKS;\n", ""),
    (SENSOR, "    place = 0;\n", ""),
    (SENSOR, "0xFF, 0x7F, 0xC0", "0xFF, 0x7E, 0xC0"),
    (SENSOR, "0x80, 0x00, 0x00\n", "0x80, 0x00, 0x08\n"),
    (SENSOR, "SENSOR_TIP_SETTINGS | AUTOMATIC, ", "SENSOR_TIP_SETTINGS, "),
    (SENSOR, "(uint8_t)(wanted[CR1] | type)", "(uint8_t)(wanted[CR1] | (type & 1u))"),
    (SENSOR, "of == CR1 ?", "of == MASK ?"),
    (SENSOR, "spi_tip_send(SENSOR_TIP_SETTINGS);", "spi_tip_send(setting(CR0));"),
    (SENSOR, "SENSOR_TIP_SETTINGS);\n        place++;", "SENSOR_TIP_SETTINGS);"),
    (SENSOR, "WRITTEN_A_TICK && place < SETTINGS", "WRITTEN_A_TICK && place + 1 < SETTINGS"),
    (SENSOR, "        spi_tip_end();\n        enter(STARTING);", "        enter(STARTING);"),
    (SENSOR, "        enter(STARTING);\n", "        enter(CONVERTING);\n"),
    (SENSOR, "    spi_tip_send(setting(CR0));\n", ""),
    (SENSOR, "(setting(CR0));\n    spi_tip_end();", "(setting(CR0));"),
    (SENSOR, "    settling_ticks = SENSOR_TIP_FIRST_TICKS;\n", ""),
    (SENSOR, "i = 0; i < SETTINGS", "i = 0; i < MASK"),
    (SENSOR, "i = 0; i < SETTINGS; i++) {\n        if (answer[i] != setting(i))",
     "i = 0; i < SETTINGS; i++) {\n        if (false)"),
    (SENSOR, "answer[i] != answer[CR0]", "false"),
    (SENSOR, "answer[CR0] == 0 || ", ""),
    (SENSOR, " || answer[CR0] == UINT8_MAX", ""),
    (SENSOR, "if (says_nothing()) {", "if (says_nothing() && false) {"),
    (SENSOR, "if (!is_set_up()) {", "if (!is_set_up() && false) {"),
    (SENSOR, "i = MASK; i < SETTINGS", "i = MASK; i < CJTO"),
    (SENSOR, "answer[CR0] == CR0_AT_POWER_UP && ", ""),
    (SENSOR, " && answer[CR1] == CR1_AT_POWER_UP", ""),
    (SENSOR, "has_started_anew() ?", "has_started_anew() && false ?"),
    (SENSOR, "return has_started_anew() ?", "return has_started_anew() || true ?"),
    (SENSOR, "if (!has_converted()) {", "if (!has_converted() && false) {"),
    (SENSOR, "LTCBL_USED = 0xE0", "LTCBL_USED = 0xF0"),
    (SENSOR, "LTCBL_USED = 0xE0", "LTCBL_USED = 0xC0"),
    (SENSOR, "CJTL_USED = 0xFC", "CJTL_USED = 0xFE"),
    (SENSOR, "if (answer[SR] & STATUS_OVUV) {", "if (false) {"),
    (SENSOR, "if (answer[SR] & STATUS_OPEN) {", "if (false) {"),
    (SENSOR, "STATUS_TC_RANGE | STATUS_CJ_RANGE)) {", "STATUS_TC_RANGE)) {"),
    (SENSOR, "STATUS_TC_RANGE | STATUS_CJ_RANGE)) {", "STATUS_CJ_RANGE)) {"),
    (SENSOR, "answer[LTCBH] << 11", "answer[LTCBH] << 10"),
    (SENSOR, "answer[LTCBM] << 3", "answer[LTCBM] << 2"),
    (SENSOR, "answer[LTCBL] >> 5", "answer[LTCBL] >> 6"),
    (SENSOR, "if (answer[LTCBH] & NEGATIVE) {", "if (false) {"),
    (SENSOR, "        settling_ticks--;\n", "        settling_ticks = 0;\n"),
    (SENSOR, "ticks_left != SENSOR_TIP_READ_TICKS", "ticks_left != SENSOR_TIP_READ_TICKS - 1u"),
    (SENSOR, "} else if (spi_tip_is_idle()) {", "} else if (true) {"),
    (SENSOR, "status = FAULT_SENSOR_SHORT; /* our", "status = FAULT_SENSOR_STALE; /* our"),
    (SENSOR, "        spi_tip_end();\n        enter(JUDGING);", "        enter(JUDGING);"),
    (SENSOR, "result == FAULT_SENSOR_NO_ANSWER || ", ""),
    (SENSOR, " || result == FAULT_SENSOR_RESET", ""),
    (SENSOR, " || result == FAULT_SENSOR_CRC", ""),
    (SENSOR, "    status = FAULT_SENSOR_STALE; /* what", "    /* what"),
    (WIRES, "    pin_sensor_tip_select_high();\n    pin_sensor_tip_select_drive();", ""),
    (WIRES, "    pin_sensor_tip_told_drive();\n", ""),
    (WIRES, "    pin_sensor_tip_data_pull_up();\n", ""),
    (WIRES, "bits & 0x80u", "bits & 0x40u"),
    (WIRES, "        bits = (uint8_t)(bits << 1);\n        settle();", "        settle();"),
    (WIRES, "pin_sensor_tip_clock_high();\n        settle();", "pin_sensor_tip_clock_high();"),
    (WIRES, "        pin_sensor_tip_clock_low();\n        settle();\n    }\n    return bits;",
     "        settle();\n    }\n    return bits;"),
    (WIRES, "    pin_sensor_tip_select_low();\n", ""),
]  # fmt: skip


@cache
def sources() -> dict[str, str]:
    return dict(render(plan_firmware(spec_of(period=SHORT_PERIOD))))


def built(folder: Path, files: dict[str, str]) -> Elf:
    write(files, folder)
    return Elf(build(folder).elf)


def complaints(program: Elf) -> Iterator[str]:
    """Say what is wrong with a binary of the crucible."""
    device = AvrDevice(spec_of(period=SHORT_PERIOD).controller, program)
    chip = device.sensors["tip"]
    assert isinstance(chip, Max31856)
    yield from _sets_it_up(device, chip)
    yield from _reads(device)
    yield from _judges(device, chip)
    yield from _recovers(device, chip)
    if chip.port.violations or chip.misused:
        yield f"{chip.port.phases}, {chip.misused}"


def steps(device: AvrDevice, count: int) -> list[tuple[int, int]]:
    """Run so many periods; status and raw of each."""
    done = len(device.steps("crucible"))
    device.advance(device.time_s + count * PERIOD_S)
    found = device.steps("crucible")[done:]
    return [(int(step["reading_status"]), int(step["reading_raw"])) for step in found]


def _sets_it_up(device: AvrDevice, chip: Max31856) -> Iterator[str]:
    """Whatever it was told before; and its first conversion is waited for."""
    chip.was_told(LATE)
    device.sense("tip", 30.0)
    device.advance(0.02)
    found = steps(device, 3)
    if found != [(STALE, 0), (VALID, 30 * 128), (VALID, 30 * 128)]:
        yield f"first readings {found}"
    if chip._registers[: len(SETTINGS)] != SETTINGS or chip.orders != 2:
        yield f"settings {chip._registers.hex()} after {chip.orders} orders"


def _reads(device: AvrDevice) -> Iterator[str]:
    for code in (128, 20 * 128 + 101, 1299 * 128 + 64, -199 * 128 - 77, -1, 77):
        device.sense("tip", code / 128)
        found = steps(device, 2)[-1]
        if found != (VALID, code):
            yield f"{code} read as {found}"


def _judges(device: AvrDevice, chip: Max31856) -> Iterator[str]:
    """Answers of each sort, after a good one; none changes the reading."""
    before = steps(device, 1)[-1]
    good = bytes([1, 0x40, 0])
    for answer, status in (
        (SETTINGS + JUNCTION + good + b"\x01", OPEN),
        (SETTINGS + JUNCTION + good + b"\x41", OPEN),
        (SETTINGS + JUNCTION + good + b"\x40", RANGE),
        (SETTINGS + JUNCTION + good + b"\x80", RANGE),
        (SETTINGS + JUNCTION + good + b"\x03", SHORT),
    ):
        found = answered(device, chip, answer)
        if found != (status, before[1]):
            yield f"{answer.hex()} judged as {found}"
    for answer in (
        SETTINGS + JUNCTION + bytes(4),
        SETTINGS + bytes(3) + b"\x01\x40\x00",
        SETTINGS + bytes([0, 4]) + bytes(4),
        SETTINGS + bytes([0, 0, 0, 0, 0x20, 0]),
        SETTINGS + bytes([25, 3, 1, 0x40, 0x1F, 0]),
    ):
        found = answered(device, chip, answer)
        if found != (VALID, int.from_bytes(answer[12:15], "big") >> 5):
            yield f"0 degC judged as {found}"


def answered(device: AvrDevice, chip: Max31856, answer: bytes) -> tuple[int, int]:
    """Let it answer so once."""
    chip._word = lambda: int.from_bytes(answer, "big")  # type: ignore[method-assign]
    found = steps(device, 1)[-1]
    del chip._word  # type: ignore[method-assign]
    return found


def _recovers(device: AvrDevice, chip: Max31856) -> Iterator[str]:
    """What must be set up anew is, at once; what need not be is not."""
    device.sense("tip", 30.0)
    for answer, status in (
        (SETTINGS + bytes(6), NO_ANSWER),
        (SETTINGS + bytes([0, 3, 0, 0, 0x1F, 0]), NO_ANSWER),
        (POWER_ON, RESET),
        (SETTINGS[:9] + b"\x01" + JUNCTION + bytes([1, 0x40, 0, 0]), CRC),
        (POWER_ON[:9] + b"\x01" + POWER_ON[10:], CRC),
        (b"\x11" + POWER_ON[1:], CRC),
        (POWER_ON[:1] + b"\x13" + POWER_ON[2:], CRC),
        (bytes(16), NO_ANSWER),
        (b"\xff" * 16, NO_ANSWER),
    ):
        steps(device, 3)
        orders = chip.orders
        found = answered(device, chip, answer), *steps(device, 2)
        if [each[0] for each in found] != [status, STALE, VALID] or chip.orders != orders + 2:
            yield f"{answer.hex()}: {found} with {chip.orders - orders} orders"
    orders = chip.orders
    if steps(device, 3) != [(VALID, 30 * 128)] * 3 or chip.orders != orders:
        yield "set up although nothing was wrong"
    chip.short("low")
    if steps(device, 1)[-1][0] != SHORT:
        yield "a short of its answers"
    chip.short(None)
    if [each[0] for each in steps(device, 2)] != [VALID, VALID] or chip.orders != orders:
        yield "after a short"
    chip.unplug()
    steps(device, 1)
    if steps(device, 1)[-1][0] not in {NO_ANSWER, STALE}:
        yield "a chip that is not there"


def test_unbroken_it_has_no_complaint(tmp_path: Path) -> None:
    assert list(complaints(built(tmp_path, sources()))) == []


@pytest.mark.parametrize("number", range(len(MUTANTS)))
def test_a_broken_one_is_seen(number: int, tmp_path: Path) -> None:
    path, old, new = MUTANTS[number]
    files = dict(sources())
    assert files[path].count(old) == 1, old
    files[path] = files[path].replace(old, new)
    assert next(complaints(built(tmp_path, files)), "") != "", MUTANTS[number]
