"""Processors that others have written, as judges of ours: what each gets wrong, how to run it.

What is named here of a judge was shown to be wrong by the manual (Microchip DS40002198, "AVR
Instruction Set Manual") and by the other judges; the streams for a judge keep clear of just that.
simavr's keep clear of nothing but wide skips: it judges all that avr8js and QEMU get wrong.
"""

import base64
import json
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from shutil import which
from types import SimpleNamespace
from typing import Any

import pytest
from rig.firmware import ROOT
from streams import RECORD, REGISTERS, Errors, H, Image, S, V, Z

from heatwright.sim.avr import Avr

AVR8JS = ROOT / "build" / "judges" / "node_modules" / "avr8js"
MACHINES = {"atmega328p": "uno", "atmega2560": "mega2560"}
VECTORS = {
    "atmega328p": {"watchdog": 0x0C, "timer1": 0x16, "timer2": 0x0E, "usart": 0x24, "adc": 0x2A},
    "atmega2560": {"watchdog": 0x18, "timer1": 0x22, "timer2": 0x1A, "usart": 0x32, "adc": 0x3A},
}
"""Word addresses of the first interrupt of each (data sheets)."""
REMEDY = "is missing: make setup EVIDENCE=1"
CLOCK_HZ = 16_000_000
MOST_CYCLES = 400_000
DONE = 0xA5

# simavr 1.6, sections CPSE, SBRC, SBRS, SBIC, SBIS: it skips two words over ADIW, SBIW with
# K & 12 == 12 (is_instruction_32_bits masks with 0xfc0f; later versions with 0xfe0f).
ADDITIONS = ("add", "adc", "sub", "sbc", "cp", "cpc", "cpi", "subi", "sbci")
"""avr8js 0.21, sections ADD to SBCI: H is the carry out of bit 3; it takes bit 0's."""
AVR8JS_FLAGS = dict.fromkeys(ADDITIONS, (H,)) | {
    "sbiw": (H,),  # section SBIW: H is left as it was; it is cleared
    "neg": (H, V, S),  # section NEG: H = R3 + Rd3, V only for 0x80; both by another operation
    "fmulsu": (Z,),  # section FMULSU: Z from the result; from the product before its shift
}
AVR8JS_CYCLES = ("cbi",)
"""avr8js 0.21, section CBI: two cycles on these parts; it takes one."""
QEMU_PAGES = 1
"""QEMU 7.2, sections ELPM and OUT: RAMPZ as it was written; OUT to it does not reach ELPM."""

ERRORS = {
    "simavr": Errors(wide_skips=True),
    "avr8js": Errors(flags=AVR8JS_FLAGS, cycles=AVR8JS_CYCLES),
    # Neither has its machine GPIOR0, nor does it count cycles.
    "qemu": Errors(pages=QEMU_PAGES, registers=False, timed=False),
}


def loaded(mcu: str, flash: bytes, *, simavrs: bool = False) -> Avr:
    """Return the product's processor with this flash, on one of its two cores."""
    avr = Avr(mcu, CLOCK_HZ)
    if simavrs:
        avr.use_simavrs_core()
    program: Any = SimpleNamespace(flash=flash, eeprom=b"", static_ram=(0, 0))
    avr.load(program)
    return avr


def on_ours(image: Image, *, simavrs: bool = False) -> bytes:
    """Run an image in the product's simulator, by one of its two cores; return its RAM."""
    avr = loaded(image.chip.mcu, image.flash, simavrs=simavrs)
    avr.run_to(MOST_CYCLES)
    assert avr.program_counter == 2 * image.end
    return avr.read_ram(image.chip.ram_start, image.chip.ram_end + 1 - image.chip.ram_start)


def on_avr8js(images: Sequence[Image]) -> list[bytes]:
    told = [
        {"flash": base64.b64encode(image.flash).decode(), "end": image.end,
         "ram_start": image.chip.ram_start, "ram_end": image.chip.ram_end,
         "timer1": VECTORS[image.chip.mcu]["timer1"]}
        for image in images
    ]  # fmt: skip
    return [base64.b64decode(ram) for ram in node("avr8js_streams.cjs", {"images": told})]


def node(script: str, told: dict[str, Any]) -> Any:
    """Run a script of this folder with avr8js; it is told and answers JSON."""
    if which("node") is None or not AVR8JS.exists():
        pytest.skip(f"avr8js {REMEDY}")
    done = subprocess.run(
        ["node", Path(__file__).parent / script],
        input=json.dumps({"module": str(AVR8JS), **told}),
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def on_qemu(images: Sequence[Image], folder: Path) -> list[bytes]:
    if which("qemu-system-avr") is None:
        pytest.skip(f"QEMU {REMEDY}")
    return [_qemu(image, folder) for image in images]


def _qemu(image: Image, folder: Path) -> bytes:
    flash, ram = folder / "flash.bin", folder / "ram.bin"
    flash.write_bytes(image.flash)
    machine = ["-machine", MACHINES[image.chip.mcu], "-bios", str(flash)]
    quiet = ["-display", "none", "-serial", "null", "-monitor", "none", "-qmp", "stdio"]
    with subprocess.Popen(
        ["qemu-system-avr", *machine, *quiet],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as qemu:  # fmt: skip
        assert qemu.stdin is not None
        assert qemu.stdout is not None

        def ask(order: str, **arguments: Any) -> None:
            told = json.dumps({"execute": order, "arguments": arguments})
            print(told, file=qemu.stdin, flush=True)
            while "return" not in (answer := json.loads(qemu.stdout.readline())):
                assert "error" not in answer, answer

        qemu.stdout.readline()  # its greeting
        ask("qmp_capabilities")
        size = image.chip.ram_end + 1 - image.chip.ram_start
        for _ in range(1000):
            ask("pmemsave", val=0x800000 + image.chip.ram_start, size=size, filename=str(ram))
            if ram.read_bytes()[-1] == DONE:
                break
            time.sleep(0.01)
        ask("quit")
    found = ram.read_bytes()
    assert found[-1] == DONE, "QEMU has not come to the end"
    return found


PLACES = (
    *(f"memory {n}" for n in range(48)), *(f"stack {n}" for n in range(REGISTERS - 48)),
    *(f"r{n}" for n in range(32)), "SREG", "SPL", "SPH", "RAMPZ",
)  # fmt: skip


def differences(image: Image, ours: bytes, theirs: bytes, *, timed: bool) -> Iterator[str]:
    """Yield what differs, a line for each stream."""
    for number, names in enumerate(image.names):
        start = number * RECORD
        records = zip(PLACES, ours[start : start + RECORD], theirs[start:], strict=False)
        found = [f"{place} {a:#04x} {b:#04x}" for place, a, b in records if a != b]
        if timed and number and number not in image.untimed:
            a, b = (cycles(ram, number) for ram in (ours, theirs))
            found += [f"cycles {a} {b}"] if a != b else []
        if found:
            yield f"stream {number}: {', '.join(found)}: {' '.join(names)}"


def cycles(ram: bytes, number: int) -> int:
    """Return the cycles between the ends of the stream before and of this one."""
    places = (number * RECORD, (number + 1) * RECORD)
    before, end = (int.from_bytes(ram[place - 2 : place], "little") for place in places)
    return (end - before) & 0xFFFF
