"""The sensors' C, broken in one place at a time: each time something below has to see it."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from analog_specs import bed, sensor

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.reference.adc import converter
from heatwright.spec import BOARDS
from heatwright.spec.conversion import conversion

OVERSAMPLE = 4
STALE, OPEN = 4, 17
MUTANTS = [
    ("src/sensor_bed.c", "code < SENSOR_BED_CODE_LOW", "code <= SENSOR_BED_CODE_LOW"),
    ("src/sensor_bed.c", "code < SENSOR_BED_CODE_FAR_LOW", "code <= SENSOR_BED_CODE_FAR_LOW"),
    ("src/sensor_bed.c", "code > SENSOR_BED_CODE_HIGH", "code >= SENSOR_BED_CODE_HIGH"),
    ("src/sensor_bed.c", "code > SENSOR_BED_CODE_FAR_HIGH", "code >= SENSOR_BED_CODE_FAR_HIGH"),
    ("src/sensor_bed.c", "FAULT_SENSOR_SHORT : FAULT_SENSOR_RANGE", "FAULT_SENSOR_OPEN : 18"),
    ("src/sensor_bed.c", "FAULT_SENSOR_OPEN : FAULT_SENSOR_RANGE", "FAULT_SENSOR_SHORT : 18"),
    ("src/sensor_bed.c", "        status = judgement;\n", "        status = READING_OK;\n"),
    ("src/sensor_bed.c", "if (judgement != READING_OK)", "if (judgement != 0xFF)"),
    ("src/sensor_bed.c", "    status = READING_OK;\n    sum", "    sum"),
    ("src/sensor_bed.c", "    sum = 0;\n", ""),
    ("src/sensor_bed.c", "sum + code", "sum + code + 1u"),
    ("src/sensor_bed.c", "|| !adc_is_fresh()", ""),
    ("src/sensor_bed.c", "if (codes_taken != SENSOR_BED_OVERSAMPLE)", "if (codes_taken == 0xFF)"),
    ("src/sensor_bed.c", "    if (status == READING_OK) {\n        *raw", "    {\n        *raw"),
    ("src/sensor_bed.c", "        ticks_left--;\n", "        ticks_left = 0;\n"),
    ("src/adc.c", "return scanned == ADC_CHANNELS;", "return true;"),
    ("src/adc.c", "        ADCSRA = (1u << ADIF);", "        ;"),
    ("src/adc.c", "    scanned = 0;\n    convert(0);", "    convert(0);"),
    ("src/adc.c", "    scanned = 0;\n    convert(0);", "    scanned = 0;"),
    ("src/adc.c", "    channel++;\n", ""),
    ("src/adc.c", "REFERENCE = (1u << REFS0)", "REFERENCE = (3u << REFS0)"),
    ("src/celsius_bed.c", "i + 1 < SEGMENTS", "i + 2 < SEGMENTS"),
    ("src/celsius_bed.c", "points[i].celsius)\n        +", "points[i].celsius)\n        -"),
]  # fmt: skip


def complaints(program: Elf) -> Iterator[str]:
    """Say what is wrong with a binary of the bed."""
    device = AvrDevice(bed("hotend").controller, program)
    yield from _meanings(device)
    yield from _one_bad_code(device)
    yield from _hanging(device)


def hold(device: AvrDevice, code: int) -> None:
    device.avr.adc.set(1, (code + 0.5) * 5000 / 1024)


def _meanings(device: AvrDevice) -> Iterator[str]:
    """All codes next to a limit or a point of the table, and what each must be taken for."""
    table = conversion(sensor("hotend"), "atmega328p")
    law = converter(sensor("hotend"), BOARDS["uno"])
    low, high, low_limit, high_limit, _ = table.limits
    far_low, far_high = (low + low_limit) / 2, (high + high_limit) / 2
    edges = [low, far_low, high, far_high, *(point.raw / OVERSAMPLE for point in table.points)]
    for code in sorted({int(edge) + off for edge in edges for off in (-1, 0, 1)}):
        hold(device, code)
        device.advance(device.time_s + 0.4)
        last = device.steps("bed")[-1]
        status = 0 if low <= code <= high else 18
        status = 2 if code < far_low else OPEN if code > far_high else status
        if last["reading_status"] != status:
            yield f"status of {code}"
        elif status == 0 and last["reading_raw"] != OVERSAMPLE * code:
            yield f"sum of {code}"
        elif status == 0 and last["temperature_c"].tobytes() != np.float32(law(4 * code)).tobytes():
            yield f"temperature of {code}"


def _one_bad_code(device: AvrDevice) -> Iterator[str]:
    """One open code among good ones, and good ones after it."""
    hold(device, 700)
    device.advance(device.time_s + 0.45)
    for late in (4.5, 3.5, 2.5):
        step_s = float(device.steps("bed")["time_s"][-1]) + 0.2
        device.advance(step_s - late * 0.01)
        hold(device, 1023)
        device.advance(step_s - (late - 1) * 0.01)
        hold(device, 700)
        device.advance(step_s + 0.25)
        *_, spoiled, sound = device.steps("bed")
        if (spoiled["reading_status"], spoiled["reading_raw"]) != (OPEN, 4 * 700):
            yield "a bad code"
        if (sound["reading_status"], sound["reading_raw"]) != (0, 4 * 700):
            yield "after a bad code"
    step_s = float(device.steps("bed")["time_s"][-1]) + 0.2
    device.advance(step_s - 0.15)
    hold(device, 1023)
    device.advance(step_s - 0.1)
    hold(device, 700)
    device.advance(step_s + 0.05)
    if device.steps("bed")["reading_status"][-1] != 0:
        yield "a code that is not of the last"


def _hanging(device: AvrDevice) -> Iterator[str]:
    """Conversions that do not end, for a few ticks and for long."""
    step_s = float(device.steps("bed")["time_s"][-1]) + 0.2
    device.advance(step_s - 0.045)
    device.avr.adc.fail(hung=True)
    device.advance(step_s + 0.3)
    if set(device.steps("bed")["reading_status"][-2:]) != {STALE}:
        yield "a scan that hangs"
    device.avr.adc.fail()
    device.advance(device.time_s + 0.5)
    if device.steps("bed")["reading_status"][-1] != 0:
        yield "after a scan that hung"


def mutated(folder: Path, path: str, old: str, new: str) -> Elf:
    files = dict(render(plan_firmware(bed("hotend"))))
    assert files[path].count(old) == 1, old
    files[path] = files[path].replace(old, new)
    write(files, folder)
    return Elf(build(folder).elf)


def test_unbroken_it_has_no_complaint(bed_program: Elf) -> None:
    assert list(complaints(bed_program)) == []


@pytest.mark.parametrize("number", range(len(MUTANTS)))
def test_a_broken_one_is_seen(number: int, tmp_path: Path) -> None:
    program = mutated(tmp_path, *MUTANTS[number])
    assert next(complaints(program), "") != "", MUTANTS[number]
