"""The processor as a Python object, how it is built, and the binary as a device on the bench."""

import gc
import os
import resource
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, began_s, compiled, device_of, powered, running, shared, whole

from heatwright.sim.avr import RAM_FILL, Avr
from heatwright.sim.binary.elf import ElfError
from heatwright.sim.device import AvrDevice, StaleBinary
from heatwright.sim.native import SimulatorMissing, shim
from heatwright.sim.native.pins import PIN_EVENT
from heatwright.spec import Controller, digest

ENDLESS = "int main(void) { for (;;) PORTB++; }"


def test_what_does_not_fit() -> None:
    with pytest.raises(ValueError, match="attiny85 is not simulated; atmega328p"):
        Avr("attiny85", 8e6)
    program = compiled("int main(void) { for (;;) {} }", "-Wl,--defsym=x=1", mcu="atmega2560")
    program.flash = bytes(40_000)
    with pytest.raises(ValueError, match="40000 bytes, the flash 32768"):
        Avr("atmega328p", CLOCK_HZ).load(program)
    with pytest.raises(ValueError, match="not in RAM"):
        Avr("atmega328p", CLOCK_HZ).snapshots((0x100, 2), (0x800, 0x200))


def test_ram_is_not_zero_at_power_on() -> None:
    avr = Avr("atmega328p", CLOCK_HZ)
    assert (avr.ram_size, set(avr.read_ram(0x100, 2048))) == (2048, {RAM_FILL})


def test_long_logs_are_kept_whole() -> None:
    """More than the shim's own buffer: it is emptied while the run goes on."""
    avr = running("int main(void) { DDRB = 1; for (;;) PINB = 1; }")
    avr.pins.watch("PB0")
    avr.run_to(2_000_000)
    events = avr.pins.take()
    assert (len(events) > 400_000, events.dtype) == (True, PIN_EVENT)
    assert set(np.diff(events["cycle"][1:].astype(int))) <= {3, 4, 5}
    assert set((events["state"][1:] & 1)[::2]) != set((events["state"][1:] & 1)[1::2])


def test_it_stops_at_each_instruction_of_a_function() -> None:
    """As many small runs do; through sleep, and for both that sleep and do not reach it."""
    program = whole("chamber")
    gate = program.function("gate_tick")
    until = round((began_s("chamber") + 0.02) * CLOCK_HZ)
    slow, quick = powered(program), powered(program)
    for avr in (slow, quick):
        avr.run_to(until - round(0.03 * CLOCK_HZ))
    wanted = []
    while slow.cycle < until:
        slow.run_to(slow.cycle + 1)
        if slow.cycle < until and gate.start <= slow.program_counter < gate.end:
            wanted.append((slow.cycle, slow.program_counter))
    found = []
    while quick.run_to_code(gate, until):
        found.append((quick.cycle, quick.program_counter))
    assert found == wanted != []
    assert quick.cycle >= until


def trace(_: int) -> bytes:
    avr = powered(shared("blink.c"))
    avr.pins.watch("PB5")
    avr.run(20)
    return avr.pins.take().tobytes()


def test_instances_are_independent_and_deterministic() -> None:
    alone = trace(0)
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(trace, range(8))) == {alone}


def test_processors_are_freed() -> None:
    program = shared("blink.c")

    def some(count: int) -> int:
        for _ in range(count):
            avr = powered(program)
            avr.pins.watch("PB5")
            avr.run(0.05)
            del avr
        gc.collect()
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = some(200)
    assert some(1000) - before < 1000  # kB: less than 1 kB each, where one takes 50
    # What was taken from a processor keeps it alive.
    pins = running(ENDLESS).pins
    gc.collect()
    assert pins.watch("PB0") == 8


def test_an_interruption_ends_a_run_that_would_take_minutes() -> None:
    avr = running(ENDLESS)
    threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        avr.run(3600)
    cycle = avr.cycle
    assert cycle < 600 * CLOCK_HZ
    avr.run(0.001)
    assert avr.cycle >= cycle + 16_000


def test_the_binary_must_be_of_this_spec(chamber: Controller, oven: Controller) -> None:
    message = rf"another spec .digest {digest(chamber)}, not {digest(oven)}.: generate and build it"
    with pytest.raises(StaleBinary, match=message):
        AvrDevice(oven, whole("chamber"))


def test_a_binary_without_its_state(chamber: Controller) -> None:
    source = f"const uint32_t spec_digest PROGMEM __attribute__((used)) = 0x{digest(chamber)};"
    with pytest.raises(ElfError, match="no variable loop_air"):
        AvrDevice(chamber, compiled(f"{source} volatile char x; int main(void) {{ x = 1; }}"))


def test_rows_outlive_a_power_cycle_as_the_eeprom_and_the_clock_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    device = device_of("chamber", 25.5)
    device.advance(3.5)
    left = lambda undefined: bytes([undefined]) * 1024  # noqa: E731
    monkeypatch.setattr(device.avr.eeprom, "after_power_cut", left)
    device.power_cycle(undefined=0x5A)
    assert (device.avr.eeprom.contents, device.time_s) == (left(0x5A), pytest.approx(3.5, abs=1e-3))
    assert device.on_fraction("heater") == 0
    device.advance(6.0)
    steps = device.steps("air")
    assert steps.dtype.names is not None
    assert {"time_s", "steps", "reading_raw", "guard.heating_steps"} <= set(steps.dtype.names)
    assert steps["steps"].tolist() == [1, 2, 3, 1, 2]
    assert steps["temperature_c"].tolist()[1:3] == [25.5, 25.5]
    times_s = np.array([1, 2, 3, 4.5, 5.5]) + began_s("chamber")
    assert np.allclose(steps["time_s"], times_s, atol=0.02)
    with pytest.raises(KeyError):
        device.steps("nozzle")


def test_a_spec_without_a_shield() -> None:
    with pytest.raises(LookupError, match="extruder has no LcdKeypad"):
        device_of("extruder").press("up")


BUILD = [sys.executable, "-m", "heatwright.sim.native.build"]


def test_it_is_built_into_the_users_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By several processes at once, whole or not at all, and then found again."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with ThreadPoolExecutor(3) as pool:
        build = partial(subprocess.run, BUILD, check=True, capture_output=True)
        runs = list(pool.map(lambda _: build(), range(3)))
    assert {run.stderr for run in runs} == {b""}
    (path,) = {Path(run.stdout.decode().strip()) for run in runs}
    assert [path] == list((tmp_path / "heatwright" / "native").iterdir())
    before = path.stat().st_mtime_ns
    assert (shim.build(), path.stat().st_mtime_ns) == (path, before)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])  # as a full disk leaves it
    assert (shim.build(), path.stat().st_size) == (path, len(whole))


def headers(folder: Path, version: str) -> Path:
    (folder / "simavr").mkdir(parents=True)
    config = f'#define CONFIG_SIMAVR_VERSION "{version}"\n'
    (folder / "simavr" / "sim_core_config.h").write_text(config)
    return folder


REFUSED = {
    f"simavr {version} is untested: install 1.6": lambda patch, folder, version=version: (
        patch.setattr(shim, "HEADERS", (headers(folder, version),))
    )
    for version in ("1.5", "1.7", "1.8", "1.60")
} | {
    "^simavr is not installed: sudo apt-get install .*simavr.*libc6-dev$": lambda patch, folder: (
        patch.setattr(shim, "HEADERS", (folder,))
    ),
    "^There is no C compiler: sudo apt-get install .*gcc": lambda patch, folder: patch.setenv(
        "PATH", str(folder)
    ),
    "headers are not installed: sudo apt-get install .* libpython3": lambda patch, folder: (
        patch.setattr(shim.sysconfig, "get_paths", lambda: {"include": str(folder)})
    ),
}  # by what is said with an empty cache; what is missing, or another version


@pytest.mark.parametrize("words", REFUSED)
def test_what_is_missing_or_untested_is_told_with_the_command_that_installs_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    REFUSED[words](monkeypatch, tmp_path)
    with pytest.raises(SimulatorMissing, match=words):
        shim.build()


def test_a_shim_that_does_not_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(shim, "HEADERS", (headers(tmp_path / "include", "1.6"),))
    (tmp_path / "include" / "simavr" / "avr_adc.h").write_text("#error broken\n")
    with pytest.raises(SimulatorMissing, match=r"does not compile .*error"):
        shim.build()
    assert list((tmp_path / "cache" / "heatwright" / "native").iterdir()) == []


def test_a_spoilt_shim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spoilt = tmp_path / "spoilt.so"
    spoilt.write_text("not a library")
    monkeypatch.setattr(shim, "build", lambda: spoilt)
    with pytest.raises(SimulatorMissing, match=r"spoilt.so does not load"):
        shim.load.__wrapped__()


def test_a_cache_that_cannot_be_written_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    surroundings = {"XDG_CACHE_HOME": str(tmp_path / "file")}
    run = subprocess.run(BUILD, env=surroundings, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr.count("\n")) == (1, 1)
    assert "set XDG_CACHE_HOME" in run.stderr
