"""Our instruction core before other judges: avr8js (npm) and QEMU (Debian); simavr: test_core.py.

Streams go to both, and a program of computations. A whole firmware goes to avr8js alone, with its
timers, USART, ADC, EEPROM and watchdog: QEMU's machines have no pins, EEPROM or watchdog.
"""

import base64
from pathlib import Path

import judges
import numpy as np
import pytest
from rig.avr import Board, shared, whole
from rig.specs import example
from streams import CHIPS, Chip, Image, image
from suite import amount

from heatwright.sim.dwarf import Variables
from heatwright.sim.native.pins import Source, pin_name
from heatwright.spec.uses import pin_uses


def judged(judge: str, images: list[Image], folder: Path) -> list[bytes]:
    return judges.on_avr8js(images) if judge == "avr8js" else judges.on_qemu(images, folder)


@pytest.mark.parametrize("chip", CHIPS.values(), ids=CHIPS)
@pytest.mark.parametrize("judge", ["avr8js", "qemu"])
def test_streams_run_alike(judge: str, chip: Chip, tmp_path: Path) -> None:
    errors = judges.ERRORS[judge]
    images = [image(chip, seed, errors) for seed in range(amount("images_of_streams"))]
    for made, theirs in zip(images, judged(judge, images, tmp_path), strict=True):
        assert not list(judges.differences(made, judges.on_ours(made), theirs, timed=errors.timed))


@pytest.mark.parametrize("chip", CHIPS.values(), ids=CHIPS)
@pytest.mark.parametrize("judge", ["avr8js", "qemu"])
def test_a_program_computes_alike(judge: str, chip: Chip, tmp_path: Path) -> None:
    program = shared("computed.c", "-lm", mcu=chip.mcu)
    flash = program.flash.ljust(chip.flash_bytes, b"\xff")
    end = program.function("stop").start // 2
    made = Image(chip, np.frombuffer(flash, "<u2").tolist(), end, [], set())
    (theirs,) = judged(judge, [made], tmp_path)
    first, last = (address - chip.ram_start for address in program.static_ram)
    assert theirs[first:last] == judges.on_ours(made)[first:last]
    assert theirs[first] == 40
    assert len(set(theirs[first:last])) > 100


IDLE_V = 4.999
"""At every analog input: no key is pressed."""


@pytest.mark.parametrize(
    ("name", "pulled"),
    [("chamber", []), ("press", ["PB3"])],
    ids=["chamber: the thermometer holds its line low", "press: nobody drives the data line"],
)
def test_a_firmware_does_alike_with_a_silent_sensor(name: str, pulled: list[str]) -> None:
    """Pins and bytes in the same order; after each step the same in all of the static RAM."""
    controller, program = example(name).controller, whole(name)
    board, seconds = controller.board, amount("seconds_on_avr8js")
    counter = Variables(program)[f"loop_{next(iter(controller.loops))}.steps"]
    first, end = program.static_ram
    pins = {use.pin.port_name for use in pin_uses(controller) if use.pin.digital}

    avr = Board(program, board).avr
    for pin in pins:
        avr.pins.watch(pin)
        avr.pins.pull(pin, "high" if pin in pulled else None)
    for channel in range(8):
        avr.adc.set(channel, 1000 * IDLE_V)
    recorded = avr.snapshots((counter.address, counter.size), (first, end - first))
    avr.run(seconds)
    recorded_steps, images = len(recorded), recorded.take()[1]

    told = judges.node(
        "avr8js_firmware.cjs",
        {
            "flash": base64.b64encode(program.flash.ljust(board.flash_bytes, b"\xff")).decode(),
            "ram_end": board.ram_start + board.ram_bytes - 1,
            "clock_hz": board.clock_hz,
            "cycles": seconds * board.clock_hz,
            "vectors": judges.VECTORS[board.mcu],
            "ports": sorted({pin[1] for pin in pins}),
            "high": [[pin[1], int(pin[2])] for pin in pulled],
            "volts": [IDLE_V] * 8,
            "counter": {"address": counter.address, "size": counter.size},
            "ram": {"address": first, "size": end - first},
        },
    )
    assert told["resets"] == 0
    assert driven(avr.pins.take()) == [(f"P{port}{bit}", now) for port, bit, now in told["pins"]]
    sent = avr.uarts.take()["value"].tolist()
    # avr8js's transmitter has no buffer (data sheet, "Sending Frames"): how far it is differs.
    assert sent == told["sent"][: len(sent)]
    assert 0 <= len(told["sent"]) - len(sent) <= 2
    theirs = [np.frombuffer(base64.b64decode(each), np.uint8) for each in told["images"]]
    same = np.arange(first, end) != program.symbols["sent"]
    assert recorded_steps == len(images) == len(theirs) >= seconds - 1
    assert np.array_equal(images[:, same], np.array(theirs)[:, same])


def driven(events: np.ndarray) -> list[tuple[str, str]]:
    """Return what the processor does at its pins, change by change."""
    before: dict[str, str] = {}
    found = []
    for pin, state in zip(events["pin"].tolist(), events["state"].tolist(), strict=True):
        level = ("low", "high")[state & 1] if state >> 1 == Source.MCU else "in"
        if before.get(pin_name(pin), "in") != level:
            before[pin_name(pin)] = level
            found.append((pin_name(pin), level))
    return found
