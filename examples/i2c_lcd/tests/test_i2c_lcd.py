"""The display on the simulated processor: what it shows, its bus, and what happens without it."""

from __future__ import annotations

from collections.abc import Callable
from decimal import ROUND_HALF_UP, Decimal
from functools import cache
from importlib.resources import files
from pathlib import Path
from tempfile import mkdtemp
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from heatwright_i2c_lcd.simulated import Limits

from heatwright.cli.bench.parts import seats_of
from heatwright.cli.chips import complaints, display
from heatwright.cli.contract import lacking
from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.device import AvrDevice
from heatwright.sim.native.pins import pin_number
from heatwright.spec import RULES, Controller, SpecError, load_text

EXAMPLE = (files("heatwright_i2c_lcd") / "example.yaml").read_text(encoding="utf-8")
SIZE = "address: 0x27"
LARGE = EXAMPLE.replace(SIZE, "address: 0x3F, size: 20x4")
BOARDS_TRIED = {
    "16 MHz": EXAMPLE,
    "20 MHz": EXAMPLE.replace("board: uno", "board: uno\n  clock: 20 MHz"),
    "8 MHz": EXAMPLE.replace("board: uno", "board: uno\n  clock: 8 MHz"),
    "pins beyond the reach of sbi": LARGE.replace("board: uno", "board: mega2560")
    .replace("sda: A4", "sda: D49")
    .replace("scl: A5", "scl: A8"),
}
REFRESH_S = 0.5
BEFORE_STEP_S = 1.54
"""Just before a step and a refresh: what the refresh before has changed is sent by now."""
RESYNC_S = 33.0
"""The display is started again every 30 s, and then gets its page."""
COURSE_C = (58.0, 58.4, 59.3, 58.7, 57.96, 58.04, 59.0, 60.2)
"""Slow enough that no rule trips, and near enough to the setpoint that the duty changes."""

Change = tuple[str, str, str]
"""A text of a file of the firmware, and what a mistake makes of it."""


@cache
def built(text: str, *changes: Change) -> tuple[Controller, Path]:
    spec = load_text(text)
    plan = plan_firmware(spec)
    made = dict(render(plan))
    for file, was, wrong in changes:
        assert made[file].count(was) == 1
        made[file] = made[file].replace(was, wrong)
    project = Path(mkdtemp())
    write(made, project)
    return spec.controller, build(project).elf


class Bench:
    """A controller; screen -- its display."""

    def __init__(self, text: str = EXAMPLE, *changes: Change, felt_c: float = COURSE_C[0]) -> None:
        self.device = AvrDevice(*built(text, *changes))
        self.screen: Any = self.device.interfaces[-1]
        self.device.sense("air", felt_c)
        self.run(BEFORE_STEP_S)

    def run(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)

    def play(self) -> list[tuple[Any, ...]]:
        """Feel one temperature after the other; return all steps so far, without their times."""
        for felt_c in COURSE_C:
            self.device.sense("air", felt_c)
            self.run(2 * REFRESH_S)
        return self.log()

    def log(self) -> list[tuple[Any, ...]]:
        return [step[1:] for step in self.device.steps("air").tolist()]

    def page(self) -> tuple[str, ...]:
        """What it must show: the page was written a tick after the step before the last one."""
        return page_of(self.device.steps("air")[-2], len(self.screen.text))

    def comes_right(self) -> bool:
        """Return whether it shows the page of one of the latest steps, within 0.3 s."""
        for _ in range(30):
            latest = self.device.steps("air")[-4:]
            if self.screen.text in [page_of(step, len(self.screen.text)) for step in latest]:
                return True
            self.run(0.01)
        return False


@cache
def undisturbed() -> list[tuple[Any, ...]]:
    return Bench().play()


def tenths(value: Any) -> str:
    """Write a number of single precision with one decimal, rounded half away from zero."""
    tenfold = Decimal(float(np.float32(value) * np.float32(10)))
    return f"{tenfold.quantize(Decimal(1), ROUND_HALF_UP) / 10:.1f}"


def page_of(step: Any, rows: int) -> tuple[str, ...]:
    """Write what the display must show after a step of the log."""
    columns = {2: 16, 4: 20}[rows]
    code = int(step["fault.code"])
    fault = f"E{code:02} {RULES[code].display}" if code else ""
    reading, setpoint = (f"{tenths(step[name])}°C" for name in ("temperature_c", "setpoint_c"))
    duty = f"{Decimal(float(step['duty_percent'])).quantize(Decimal(1), ROUND_HALF_UP)} %"
    if rows == 2:
        lines = [("air", reading), (fault, "") if code else (f"→{setpoint}", duty)]
    else:
        lines = [("air", reading), ("setpoint", setpoint)]
        lines += [("duty", "off" if code else duty), (fault, "")]
    return tuple(left + right.rjust(columns - len(left)) for left, right in lines)


def test_nothing_is_missing() -> None:
    assert list(lacking("interface", "i2c_lcd")) == []


# ---- what it shows ----


@pytest.mark.parametrize("text", [EXAMPLE, LARGE], ids=["16x2", "20x4"])
def test_it_shows_what_the_log_says(text: str) -> None:
    bench, shown = Bench(text), set()
    for felt_c in (*COURSE_C, *reversed(COURSE_C)):
        bench.device.sense("air", felt_c)
        bench.run(REFRESH_S)
        assert bench.screen.text == bench.page()
        shown.add(bench.screen.text)
    assert len(shown) > len(COURSE_C)
    assert bench.screen.is_lit
    assert complaints(bench.device) == ()


@pytest.mark.parametrize("text", [EXAMPLE, LARGE], ids=["16x2", "20x4"])
@pytest.mark.parametrize("felt_c", [3.0, 7.04, 9.96, 59.97, 60.1, 79.95, 94.0, 99.97, 119.0])
def test_it_shows_every_number_and_fault(text: str, felt_c: float) -> None:
    bench = Bench(text, felt_c=felt_c)
    bench.run(10 * REFRESH_S)
    assert bench.screen.text == bench.page()
    assert abs(float(bench.screen.text[0].split()[-1].removesuffix("°C")) - felt_c) < 0.5
    assert (bench.screen.text[-1][0] == "E") == (not 5.0 < felt_c < 95.0)


def test_before_the_first_step_nothing_is_known() -> None:
    texts = [screen.rows for screen in Bench().screen.history]
    assert ("air       --.-°C", "→--.-°C      0 %") in texts
    assert not [rows for rows in texts if "0.0°C" in rows[1] and "60.0°C" not in rows[1]]


def test_a_fault_is_shown_at_once() -> None:
    bench = Bench()
    bench.run(0.1)  # a fault that comes 40 ms after a refresh waits for no other
    bench.device.sense("air", 99.0)
    while not bench.device.read("fault.code"):
        bench.run(0.01)
    told_s = bench.device.time_s
    bench.run(0.4)
    texts = [screen for screen in bench.screen.history if screen.rows[1] == "E08 JUMP        "]
    assert texts[0].time_s - told_s < 0.33  # 16 characters, and once an address


def test_a_loop_that_is_off_is_shown_so() -> None:
    """The shield's keys switch the loop; both displays work side by side."""
    text = EXAMPLE.replace("pin: A0", "pin: A1").replace("pin: D3", "pin: D2")
    text = text.replace("interfaces:", "interfaces:\n  - {kind: lcd_keypad, loop: air}")
    bench = Bench(text)
    assert bench.screen.text[1] == "→60.0°C      off"
    assert display(bench.device) == bench.device.shield.lcd.text
    bench.device.shield.play(("up",))
    bench.run(1.5)
    assert bench.screen.text[1].startswith("→60.0°C ")
    assert bench.screen.text[1].endswith(" %")
    assert complaints(bench.device) == ()


def test_of_two_displays_each_shows_its_own() -> None:
    more = "\n  - {kind: i2c_lcd, loop: air, sda: D5, scl: D6, size: 20x4}\n\nsimulation"
    bench = Bench(EXAMPLE.replace("\n\nsimulation", more))
    for screen in bench.device.interfaces:
        bench.screen = screen
        assert bench.comes_right()


def test_the_bench_and_a_run_show_its_text() -> None:
    bench = Bench(LARGE)
    (seat,) = seats_of(built(LARGE)[0])
    world: Any = SimpleNamespace(device=bench.device)
    assert seat.state(world) == {"rows": list(bench.page())}
    assert display(bench.device) == bench.page()


# ---- its bus ----


class Lines:
    """The levels of SDA and SCL as the pin log has them."""

    def __init__(self, bench: Bench) -> None:
        self.parts: list[Any] = []
        for pin in bench.screen.pins:
            bench.device.avr.pins.watch(pin)
        bench.device.record(self)

    def feed(self, pins: Any, sent: Any) -> None:
        del sent
        self.parts.append(pins.copy())

    def edges(self, pin: str) -> Any:
        """The cycles of the changes of a pin's level, and the level after each."""
        events = np.concatenate(self.parts)
        mine = events[events["pin"] == pin_number(pin)]
        levels = mine["state"] & 1
        changes = np.flatnonzero(np.diff(levels, prepend=1))
        return mine["cycle"][changes].astype(np.int64), levels[changes]


@pytest.mark.parametrize("name", BOARDS_TRIED)
def test_the_bus_keeps_to_the_data_sheet(name: str) -> None:
    """By the log of the pins, and by what the simulated display has measured itself."""
    bench = Bench(BOARDS_TRIED[name])
    lines = Lines(bench)
    bench.play()
    bench.device.feed()
    us = 1e6 / bench.device.avr.clock_hz
    sda, scl = map(lines.edges, bench.screen.pins)
    rises, falls = scl[0][scl[1] == 1], scl[0][scl[1] == 0]
    lows = np.min([rises[rises > fall][0] - fall for fall in falls]) * us
    highs = np.min([falls[falls > rise][0] - rise for rise in rises[:-1]]) * us
    # SDA may change while SCL is low; while it is high, a fall is a start and a rise is a stop. The
    # expander releases SDA in the very cycle in which SCL falls.
    before = np.searchsorted(scl[0], sda[0], side="right")
    up = np.concatenate([[1], scl[1]])[before]
    marks = [int(level) for level, high in zip(sda[1], up, strict=True) if high]
    assert marks == [0, 1] * (len(marks) // 2)
    assert len(marks) // 2 > 20
    least = Limits()
    assert np.min(np.diff(rises)) * us >= least.period
    assert lows >= least.low
    assert highs >= least.high
    found = bench.screen.bus.shortest
    assert found.keys() == vars(least).keys()
    assert (found["low"], found["high"]) == pytest.approx((lows, highs))
    assert complaints(bench.device) == ()
    assert bench.screen.glass.lost == 0
    assert bench.comes_right()


MISTAKES: dict[str, tuple[str, Change]] = {
    "SCL is too fast": ("high of the bus", ("src/i2c_lcd_bus.c", "_delay_us(5)", "_delay_us(4)")),
    "RS comes with E": (
        "RS or R/W changed as E rose",
        ("src/i2c_lcd.c", "_send(rs | BACKLIGHT)", "_send((uint8_t)((rs & E) | BACKLIGHT))"),
    ),
    "E falls with the data": (
        "a line changed as E fell",
        ("src/i2c_lcd.c", "i2c_lcd_bus_send(lines);", "i2c_lcd_bus_send(BACKLIGHT);"),
    ),
    "home is not waited for": (
        "it was busy",
        ("src/i2c_lcd.c", "!go_on()", "!go_on() || !go_on()"),
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_the_simulated_display_notices(name: str) -> None:
    told, change = MISTAKES[name]
    bench = Bench(EXAMPLE, change)
    assert any(told in each for each in complaints(bench.device))


@pytest.mark.parametrize("text", BOARDS_TRIED.values(), ids=BOARDS_TRIED.keys())
def test_a_transfer_takes_a_small_part_of_a_tick(text: str) -> None:
    bench = Bench(text)
    profile = bench.device.avr.profile(bench.device.elf)
    bench.play()
    for screen in ("i2c_lcd_tick", "i2c_lcd_page_tick"):
        took_s = profile.functions[screen].longest / bench.device.avr.clock_hz
        assert 0 < took_s < 0.001, screen


# ---- without it ----


def _unplugged(screen: Any) -> Callable[[], None]:
    screen.unplug()
    return cast("Callable[[], None]", screen.plug)


def _silent(screen: Any) -> Callable[[], None]:
    screen.bus.silent = True
    return lambda: setattr(screen.bus, "silent", False)


def _shorted(wire: Any, level: Any) -> Callable[[Any], Callable[[], None]]:
    def short(screen: Any) -> Callable[[], None]:
        screen.short(wire, level)
        return lambda: screen.short(wire, None)

    return short


ABSENCES: dict[str, Callable[[Any], Callable[[], None]]] = {
    "unplugged": _unplugged,
    "no acknowledgement": _silent,
    "SDA low": _shorted("sda", "low"),
    "SCL low": _shorted("scl", "low"),
    "SDA high": _shorted("sda", "high"),
    "SCL high": _shorted("scl", "high"),
}


@pytest.mark.parametrize("name", ABSENCES)
@pytest.mark.parametrize("in_transfer", [False, True])
def test_control_does_not_notice_that_it_is_away(name: str, in_transfer: bool) -> None:
    bench, twin = Bench(), Bench()
    before = bench.screen.transfers
    while in_transfer and bench.screen.transfers == before:
        bench.device.sense("air", COURSE_C[1])
        bench.device.avr.run(25e-6)
    twin.device.sense("air", COURSE_C[in_transfer])
    twin.device.advance(bench.device.time_s)
    repair = ABSENCES[name](bench.screen)
    gone = bench.screen.transfers
    assert bench.play() == twin.play()
    assert bench.screen.transfers - gone <= (9 if name == "no acknowledgement" else 1)
    assert not bench.comes_right()
    repair()
    bench.run(5 * REFRESH_S)
    assert bench.comes_right()
    assert bench.screen.glass.lost == 0


@pytest.mark.parametrize("ticks", ["5u", "0u"])
def test_a_display_that_was_just_plugged_in_has_time_to_start(ticks: str) -> None:
    """It answers at once, and is ready 15 ms after its supply came; without a wait it is lost."""
    bench = Bench(EXAMPLE, ("src/config.h", "POWER_UP_TICKS 5u", f"POWER_UP_TICKS {ticks}"))
    bench.screen.unplug()
    for tried in (False, True):
        while bench.device.avr.pins.level(bench.screen.pins[0]) == tried:
            bench.run(20e-6)
    bench.run(1.009)  # the next attempt comes 1.01 s after this one
    before = bench.screen.transfers
    bench.screen.plug()
    bench.run(0.002)
    assert bench.screen.transfers > before
    bench.run(5 * REFRESH_S)
    assert (bench.screen.glass.lost == 0) == (ticks == "5u")


@pytest.mark.parametrize("away", [True, False])
def test_a_tick_without_it_is_short(away: bool) -> None:
    bench = Bench()
    if away:
        bench.screen.short("sda", "low")
    profile = bench.device.avr.profile(bench.device.elf)
    bench.play()
    took_s = profile.functions["i2c_lcd_tick"].longest / bench.device.avr.clock_hz
    assert (took_s < 0.0003) == away


def test_a_display_that_has_forgotten_is_started_again() -> None:
    """Its supply has failed for a moment; the expander acknowledges as before."""
    bench = Bench()
    bench.screen.glass.power_on(0)
    bench.run(2 * REFRESH_S)
    assert not bench.comes_right()
    bench.run(RESYNC_S)
    assert bench.comes_right()


def test_a_nibble_too_many_is_put_right() -> None:
    """Interference on E: from then on it takes the halves of each byte as those of two."""
    bench = Bench()
    bench.screen.glass.write(int(1e9 * bench.device.time_s), 0, 0)
    bench.play()
    assert not bench.comes_right()
    bench.run(RESYNC_S)
    assert bench.comes_right()


@pytest.mark.parametrize("frees", [True, False])
def test_a_reset_within_a_byte_leaves_no_line_held(frees: bool) -> None:
    """The expander holds SDA and waits for a pulse of SCL, which the controller sends."""
    sent = ("src/i2c_lcd_bus.c", "    free_sda();\n", "")
    unused = ("src/i2c_lcd_bus.c", "static void free_sda", "void free_sda(void);\nvoid free_sda")
    bench = Bench(EXAMPLE, *(() if frees else (sent, unused)))
    bench.device.sense("air", COURSE_C[1])
    while not bench.screen.bus.holds_sda:
        bench.device.avr.run(1e-6)
    bench.device.avr.reset()
    bench.run(5 * REFRESH_S)
    assert bench.comes_right() == frees
    told = [each for each in complaints(bench.device) if "reset" not in each]
    assert told == []


def test_it_shows_its_page_again_after_a_loss_of_power() -> None:
    bench = Bench()
    bench.device.power_cycle()
    bench.screen = bench.device.interfaces[-1]
    bench.device.sense("air", COURSE_C[0])
    assert bench.screen.text == (" " * 16,) * 2
    bench.run(BEFORE_STEP_S)
    assert bench.comes_right()


# ---- flipped bits ----


def _flips() -> list[tuple[str, int, int]]:
    """The name, the address and a bit of each variable of the driver, of its arrays four bytes."""
    variables = AvrDevice(*built(EXAMPLE)).variables
    return [
        (f"{each.name}+{byte} bit {bit}", each.address + byte, bit)
        for file in ("i2c_lcd.c", "i2c_lcd_page.c")
        for each in variables.of_file(file)
        for byte in range(0, each.size, max(1, each.size // 4))
        for bit in range(8)
    ]


REGISTERS = [
    (f"{register} bit {bit}", address, bit)
    for register, address in (("DDRC", 0x27), ("PORTC", 0x28))
    for bit in (4, 5)  # SDA and SCL
]


def test_a_flipped_bit_is_put_right_and_reaches_nothing_else() -> None:
    flips = _flips() + REGISTERS
    assert len(flips) > 100
    for name, address, bit in flips:
        bench = Bench()
        bench.device.avr.flip(address, bit)
        assert bench.play() == undisturbed(), name
        bench.run(RESYNC_S)
        assert bench.comes_right(), name
        assert list(bench.device.take_resets()) == [], name


# ---- the spec ----


@pytest.mark.parametrize(
    ("was", "told", "message"),
    [
        ("0x27", "0x40", "'0x40' is no address of a PCF8574. Use 0x20 to 0x27, or 0x38 to 0x3F"),
        ("0x27", "28", "this is no address of a PCF8574"),
        ("0x27", "true", "this is no address of a PCF8574"),
        ("0x27", "0x27, size: 8x2", "16x2"),
        ("scl: A5", "scl: A4", "A4"),
        ("scl: A5", "scl: D3", "D3"),
        ("scl: A5", "scl: D99", "D99"),
        ("sda: A4, ", "", "this key is missing"),
        ("i2c_lcd, loop: air", "i2c_lcd, loop: oven", "oven"),
    ],
)
def test_a_bad_spec_is_refused(was: str, told: str, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        load_text(EXAMPLE.replace(was, told, 1))


def test_an_address_may_be_written_in_decimal() -> None:
    assert built(EXAMPLE.replace("0x27", "39"))[0].interfaces == built(EXAMPLE)[0].interfaces
