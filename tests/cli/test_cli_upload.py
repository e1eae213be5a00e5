"""`upload` and `monitor`: what avrdude and PlatformIO's monitor are told, and what avrdude writes.
It writes through the boot loaders of Arduino's core, on simulated chips."""

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest
from rig.commands import Heatwright, changed
from rig.live import answered

from heatwright.cli import ports
from heatwright.cli.commands import monitor
from heatwright.sim.avr import Avr
from heatwright.sim.binary.elf import Elf

BOOT_LOADERS = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders")  # arduino-core-avr's
OPTIBOOT = 0x7C00  # a section twice as long as its own: see `optiboot`
WINKS_S = 0.5  # after a reset Optiboot blinks; the others begin to listen at once
BUSY_S = 0.05  # longer than a boot loader takes for a request; a page is written in 4.5 ms


class Port(NamedTuple):
    device: str
    vid: int | None = 0x2341


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch) -> list[Port]:
    found = [Port("/dev/ttyS0", None), Port("/dev/ttyACM0")]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: found)
    monkeypatch.setattr(ports, "WAIT_S", 0.0)
    return found


@pytest.fixture
def avrdude(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An avrdude that writes down what it is told, and fails where `fails` is there."""
    folder = tmp_path / "bin"
    folder.mkdir()
    tool = folder / "avrdude"
    tool.write_text(
        f'#!/bin/sh\nprintf "%s\\n" "$@" >{tmp_path}/told\n'
        f"[ ! -e {tmp_path}/fails ] || {{ echo not in sync >&2; exit 1; }}\n"
    )
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")
    return tmp_path / "told"


BARE = ("dryer", "board: atmega16", "board: atmega16")


@pytest.mark.parametrize(
    ("spec", "options", "words"),
    [
        (None, "", "-p atmega328p -c arduino -b 115200 -D -P /dev/ttyACM0"),
        (None, "--port COM3", "-p atmega328p -c arduino -b 115200 -D -P COM3"),
        (None, "--programmer usbasp", "-p atmega328p -c usbasp"),
        (BARE, "--programmer usbasp", "-p atmega16 -c usbasp"),
    ],
)
@pytest.mark.usefixtures("plugged")
def test_the_binary_that_is_judged_is_written(
    heatwright: Heatwright, avrdude: Path, spec: Any, options: str, words: str
) -> None:
    name = "chamber.yaml" if spec is None else changed(*spec)
    (elf,) = heatwright(f"build {name} --json").json["files"]
    told = heatwright(f"upload {name} {options} --json").json
    hexed = elf.removesuffix("elf") + "hex"
    assert told["file"] == hexed
    assert Path(hexed).is_file()
    assert avrdude.read_text().split() == ["-q", *words.split(), "-U", f"flash:w:{hexed}:i"]
    assert f"Next: heatwright monitor {name}" in heatwright(f"upload {name} {options}").out


@pytest.mark.usefixtures("plugged", "avrdude")
def test_a_board_without_a_line_has_no_monitor_to_go_on_to(heatwright: Heatwright) -> None:
    mute = changed("oven", "  - {kind: serial_plotter, loop: air, baud: 9600, line_end: CR LF}", "")
    assert "Next: Commissioning, in its README" in heatwright(f"upload {mute}").out


def test_a_bare_chip_needs_a_programmer(heatwright: Heatwright, avrdude: Path) -> None:
    told = heatwright(f"upload {changed(*BARE)}", status=2).err
    assert "atmega16 is a bare chip, without a boot loader" in told
    assert not avrdude.exists()


def test_what_avrdude_says_is_told(
    heatwright: Heatwright, avrdude: Path, plugged: Any, tmp_path: Path
) -> None:
    (tmp_path / "fails").touch()
    told = heatwright("upload chamber.yaml", status=2).err
    assert "Is it plugged in" in told
    assert told.endswith("avrdude said:\n  not in sync\n")


def test_without_avrdude_it_is_one_line(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("heatwright.cli.commands.upload.which", lambda *_, **__: None)
    told = "avrdude is missing: sudo apt-get install avrdude\n"
    assert heatwright("upload chamber.yaml", status=3).err == told


def optiboot(folder: Path) -> Path:
    """Compile the Uno's: what Debian's compiler made of it is longer than its boot section."""
    source, made = BOOT_LOADERS / "optiboot", folder / "optiboot.elf"
    words = ["-Os", "-w", "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DBAUD_RATE=115200"]
    words += ["-DLED_START_FLASHES=3", f"-I{source}", "-nostartfiles", "-Wl,--relax"]
    words += [f"-Wl,--section-start=.text={OPTIBOOT:#x}", f"{source}/optiboot.c", "-o", f"{made}"]
    subprocess.run(["avr-gcc", *words], check=True)
    return made


def image(loader: Path) -> bytes:
    made = Path("loader.bin").resolve()
    form = ["-I", "ihex"] if loader.suffix == ".hex" else ["-j", ".text"]
    subprocess.run(["avr-objcopy", *form, "-O", "binary", loader, made], check=True)
    return made.read_bytes()


@contextmanager
def waiting_board(mcu: str, loader: Path, start: int, baud: int) -> Iterator[tuple[str, Avr]]:
    """A chip that has just been reset, as its port's opening does, and the name of its line. Its
    time goes on only while there is something to answer: no computer is too slow for it."""
    avr = Avr(mcu, 16e6)
    flash = b"\xff" * start + image(loader)
    program: Any = SimpleNamespace(flash=flash, eeprom=b"", static_ram=(0, 0))
    avr.load(program)
    avr.reset("external")
    avr.jump(start)
    avr.run(WINKS_S)
    busy_until_s = 0.0

    def turn(line: int, _: Event) -> None:
        nonlocal busy_until_s
        with suppress(BlockingIOError):
            avr.uarts[0].send(os.read(line, 4096), baud)
        if avr.uarts[0].unsent:
            busy_until_s = avr.time_s + BUSY_S
        if avr.time_s >= busy_until_s:
            time.sleep(0.0005)
        else:
            avr.run(0.001)
            os.write(line, bytes(avr.uarts.take()["value"]))

    with answered(turn) as port:
        yield port, avr


LOADERS = {
    "uno": ("atmega328p", "", OPTIBOOT, 115200),
    "nano": ("atmega328p", "atmega/ATmegaBOOT_168_atmega328.hex", 0x7800, 57600),
    "mega2560": ("atmega2560", "stk500v2/stk500boot_v2_mega2560.hex", 0x3E000, 115200),
}  # by board: its chip, the loader's file if there is one, where it begins, and its speed


@pytest.mark.parametrize("board", LOADERS)
def test_avrdude_writes_through_its_loader(
    heatwright: Heatwright, tmp_path: Path, board: str
) -> None:
    mcu, loader, start, baud = LOADERS[board]
    name = changed("barrel", "board: uno", f"board: {board}")
    file = BOOT_LOADERS / loader if loader else optiboot(tmp_path)
    with waiting_board(mcu, file, start, baud) as (port, avr):
        told = heatwright(f"upload {name} --port {port} --json").json
        flash = Elf(Path(told["file"]).with_suffix(".elf")).flash
        assert avr.read_flash(0, len(flash)) == flash


@pytest.mark.parametrize("command", ["upload", "monitor"])
def test_the_port_is_found_or_asked_for(
    heatwright: Heatwright, avrdude: Path, plugged: list[Port], command: str
) -> None:
    plugged.append(Port("/dev/ttyUSB0"))
    told = heatwright(f"{command} chamber.yaml", status=2).err
    assert "name one with --port: /dev/ttyACM0, /dev/ttyUSB0." in told
    del plugged[1:]
    assert "No board was found" in heatwright(f"{command} chamber.yaml", status=2).err


def test_the_monitor_speaks_as_the_spec_says(
    heatwright: Heatwright, plugged: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[str] = []
    monkeypatch.setattr(monitor.subprocess, "call", lambda words: given.extend(words) or 0)
    heatwright(f"monitor {changed(*BARE)}")
    words = "-m platformio device monitor --port /dev/ttyACM0 --baud 38400 --parity O"
    assert given[1:] == words.split()
    mute = changed("oven", "  - {kind: serial_plotter, loop: air, baud: 9600, line_end: CR LF}", "")
    assert "has no serial line" in heatwright(f"monitor {mute}", status=2).err
