"""Pulse width at the pins: every compare output of every chip, and any pin by interrupts."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from rig.firmware import sources_of
from rig.outputs import TICK_S, OutputBoard, Outputs, Wired, reset_problem, wired

from heatwright.sim.binary.elf import Elf
from heatwright.spec import BOARDS
from heatwright.spec.board.pwm_timers import FREQUENCY_TOLERANCE, LATEST_INTERRUPT_S, PwmChannel
from heatwright.spec.board.timers import allocate

CLOCK_HZ = 16_000_000
TCCR2A, TIMSK1 = 0xB0, 0x6F
LATENCY = 200  # Cycles: from the match to the pin. Its own interrupt, and the tick's before it.
INSTRUCTION = 12
"""Cycles: the simulator moves a timer's pin after an instruction, or after the 8 cycles in which
the processor wakes and enters an interrupt."""


class Pulses(NamedTuple):
    """What was seen of an output, in cycles of the processor, and the share of time it was on."""

    periods: NDArray[np.int64]
    widths: NDArray[np.int64]
    share: float


class PwmBoard(OutputBoard):
    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        self.channels: dict[str, PwmChannel] = dict(allocate(self.controller).pwm)
        self.avr.run(0.05)

    def ask(self, name: str, percent: float) -> None:
        super().ask(name, percent)
        self.avr.run(0.03 + 2 / self.channels[name].frequency_hz)

    def seen(self, name: str, seconds: float) -> Pulses:
        switch = self.outputs[name]
        switch.on_fraction()
        self.avr.pins.take()
        self.avr.run(seconds)
        share = switch.on_fraction()
        events = self.avr.pins.take()
        mine = events[events["pin"] == switch.number]
        on = (mine["state"] & 1 == 1) == (switch.active == "high")
        cycles = mine["cycle"].astype(np.int64)
        begins, ends = cycles[on], cycles[~on]
        begins_whole = begins[begins < ends[-1]] if len(ends) else begins[:0]  # of whole pulses
        widths = ends[np.searchsorted(ends, begins_whole)] - begins_whole
        return Pulses(np.diff(begins), widths, share)

    def cycles_of(self, name: str) -> int:
        return self.channels[name].prescaler * self.channels[name].counts

    def late(self, name: str) -> int:
        return LATENCY if self.channels[name].by_interrupts else INSTRUCTION

    def wrong(self, name: str, percent: float, seconds: float) -> str:
        """Ask for a share that is pulses; say what is wrong with them."""
        self.ask(name, percent)
        pulses, late = self.seen(name, seconds), self.late(name)
        if percent in {0.0, 100.0} or not len(pulses.periods):
            return "" if pulses.share == percent / 100 else f"{percent} % are {pulses.share}"
        # No drift: what one edge is late the next period is short of.
        if abs(pulses.periods - self.cycles_of(name)).max() > late:
            return f"periods of {pulses.periods}, not {self.cycles_of(name)}"
        drift = pulses.periods.sum() - len(pulses.periods) * self.cycles_of(name)
        if abs(drift) > late:
            return f"a drift of {drift} cycles"
        channel = self.channels[name]
        due = int(percent * channel.counts / 100 + 0.5) * channel.prescaler
        if abs(pulses.widths - due).max() > late:
            return f"pulses of {pulses.widths}, not {due}, at {percent} %"
        return ""


def placed(board: str, outputs: Outputs) -> Wired:
    return wired(board, {name: f"kind: pwm, pin: {said}" for name, said in outputs.items()})


def heater_problems(place: Wired, elf: Elf | None = None) -> Iterator[str]:
    """Say what is wrong with a heater's pulses, one after the other; by interrupts at 490 Hz."""
    bench = PwmBoard(place, elf)
    for percent in (50.0, 5.0, 95.0, 0.0, 30.0, 100.0, 40.0, 0.0, 60.0):
        yield bench.wrong("heater", percent, 0.1)
        if percent in {0.0, 100.0} and runs(bench):
            yield f"at {percent} % the timer's pulses are left running"
    if not bench.channels["heater"].by_interrupts:
        yield bench.wrong("heater", 99.6, 0.1)  # a count less than all
    yield gate_problem(bench)
    if bench.channels["heater"].by_interrupts:
        yield from shortest_problems(bench)
        yield from late_problems(bench)


def runs(bench: PwmBoard) -> bool:
    """Say whether, on an uno, timer 2 sets its pin or timer 1 interrupts."""
    place, mask = (TIMSK1, 2) if bench.channels["heater"].by_interrupts else (TCCR2A, 0x30)
    return bool(bench.avr.read_ram(place, 1)[0] & mask)


def shortest_problems(bench: PwmBoard) -> Iterator[str]:
    """Ask for the shortest pulse and pause by interrupts, and for one count less."""
    channel = bench.channels["heater"]
    least = math.ceil(LATEST_INTERRUPT_S * bench.avr.clock_hz / channel.prescaler)
    percent = 100 / channel.counts
    for counts in (0, 1, least - 1, least):
        for asked in (counts, channel.counts - counts):
            bench.ask("heater", asked * percent)
            share = bench.seen("heater", 0.1).share
            if counts < least and share != float(asked > least):
                yield f"{asked} counts are {share}"
            if counts == least and not 0 < share < 1:
                yield f"{asked} counts, enough for an interrupt, are {share}"


def gate_problem(bench: PwmBoard) -> str:
    heater = bench.outputs["heater"]
    for percent in (100.0, 95.0, 50.0, 3.0):
        bench.put("permitted", 1)
        bench.ask("heater", percent)
        if abs(bench.seen("heater", 0.1).share - percent / 100) > 0.02:
            return "not on again"
        bench.put("permitted", 0)
        bench.avr.run(TICK_S)
        if heater.on or not heater.driven or bench.seen("heater", 0.2).share:
            return "on, or not driven, with the gate closed"
        bench.ask("heater", 90.0)
        if bench.seen("heater", 0.2).share:
            return "an order opens the gate"
    bench.put("permitted", 1)
    bench.avr.run(TICK_S)
    return ""


def late_problems(bench: PwmBoard) -> Iterator[str]:
    """Say what late interrupts do that they must not: at 490 Hz a tick finds every phase."""
    for deaf_us, percent in ((300, 50.0), (1800, 97.0), (1800, 3.0), (2000, 50.0)):
        bench.put("deaf_us", deaf_us)
        bench.ask("heater", percent)
        periods, widths, _ = bench.seen("heater", 20.0)
        whole, late = bench.cycles_of("heater"), deaf_us * 16
        pulse = percent / 100 * whole
        # Who sleeps through a pause goes on with the next pulse.
        most = pulse + (late if late < whole - pulse else whole) + 2 * LATENCY
        if not len(widths) or widths.max() > most:
            yield f"a pulse of {max(widths, default=0)} cycles, {most} at most"
        if len(periods) < 20.0 / (2 * (TICK_S + deaf_us / 1e6)):
            yield f"only {len(periods)} pulses"
    bench.put("deaf_us", 0)
    yield bench.wrong("heater", 50.0, 0.1)


def restart_problem(bench: PwmBoard) -> str:
    """Jump to 0, which leaves the timers as they were: say whether it is not off at once."""
    heater = bench.outputs["heater"]
    profile = bench.avr.profile(bench.program)
    profile.trace("start_again")
    for phase in range(5):
        bench.ask("heater", 60.0)
        if bench.seen("heater", 0.1 + 0.0003 * phase).share <= 0.5:
            return "not on before"
        bench.put("restart", 1)
        bench.avr.run(2 * TICK_S)
        (began,) = profile.entries("start_again")
        # Not the program's later start of its outputs: that comes some 300 cycles on.
        if any(change.cycle > began + 40 for change in bench.changes()):
            return "off, but late"
        if heater.on or not heater.driven or bench.seen("heater", 0.3).share:
            return "on, or not driven, after a jump to 0"
    return ""


CHIPS = ("uno", "mega2560", "leonardo", "atmega644p", "atmega1284p", "atmega32", "atmega16")

either_level = pytest.mark.parametrize("active", ["high", "low"])


def timers() -> Iterator[tuple[str, int, tuple[str, ...]]]:
    for board in CHIPS:
        pins = {pin.port_name: pin for pin in BOARDS[board].pins.values() if pin.pwm}
        for number in BOARDS[board].timers:
            found = tuple(pin.name for pin in pins.values() if pin.pwm and pin.pwm[0] == number)
            yield board, number, found


@pytest.mark.parametrize(("board", "number", "pins"), list(timers()))
@either_level
def test_every_compare_output(board: str, number: int, pins: tuple[str, ...], active: str) -> None:
    wide = BOARDS[board].timers[number].bits == 16
    said = f"frequency: {1000 if wide else 976.5625} Hz, active: {active}"
    outputs = {f"fan_{pin.lower()}": f"{pin}, {said}" for pin in pins}
    bench = PwmBoard(placed(board, outputs))
    for name in outputs:
        channel = bench.channels[name]
        assert (channel.timer, channel.by_interrupts) == (number, False)
        switch = bench.outputs[name]
        assert (switch.on, switch.driven) == (False, True)  # off is forced from the start on
        for percent in (0.4, 25.0, 50.0, 99.6):
            assert bench.wrong(name, percent, 0.02) == ""
        for percent in (100.0, 0.0, 50.0, 0.0):
            assert bench.wrong(name, percent, 0.02) == ""
            assert percent == 50.0 or switch.on == (percent > 0)


@pytest.mark.parametrize(
    ("board", "pin", "frequency_hz", "by_interrupts"),
    [
        ("uno", "D9", 30, False), ("uno", "D10", 122, False), ("uno", "D9", 31_000, False),
        ("uno", "D3", 62_500, False), ("uno", "D3", 30, True), ("uno", "D4", 122, True),
        ("uno", "A5", 1, True), ("nano", "D5", 500, True),
        ("mega2560", "D46", 30, False), ("mega2560", "D8", 122, False),
        ("mega2560", "D5", 31_000, False),
        # RAMPS: the hotend, and its fan; ports H and K take several instructions.
        ("mega2560", "D10", 30, True), ("mega2560", "D9", 122, True), ("mega2560", "A8", 250, True),
        ("leonardo", "D9", 122, False), ("leonardo", "D5", 31_000, False),
        ("leonardo", "D6", 30, True),  # its own timer, the fourth, is left out
        ("atmega1284p", "PB6", 30, False), ("atmega1284p", "PD4", 31_000, False),
        ("atmega1284p", "PB3", 122, True), ("atmega1284p", "PA5", 499, True),
        ("atmega32", "PD5", 30, False), ("atmega32", "PD4", 31_000, False),
        # Timer 2 divides by 128, timer 0 does not.
        ("atmega32", "PD7", 488.28125, False), ("atmega32", "PB3", 488.28125, True),
        ("atmega16", "PB3", 62_500, False), ("atmega16", "PA5", 122, True),
    ],
)  # fmt: skip
@either_level
def test_frequency_and_share(
    board: str, pin: str, frequency_hz: float, by_interrupts: bool, active: str
) -> None:
    said = f"{pin}, frequency: {frequency_hz} Hz, active: {active}"
    bench = PwmBoard(placed(board, {"fan": said}))
    assert bench.channels["fan"].by_interrupts == by_interrupts
    shortest = 5 + LATEST_INTERRUPT_S * frequency_hz * 100 * by_interrupts
    for percent in (shortest, 33.3, 100 - shortest):
        assert bench.wrong("fan", percent, max(0.05, 12 / frequency_hz)) == ""
    pulses = bench.seen("fan", max(0.05, 12 / frequency_hz))
    found_hz = CLOCK_HZ / pulses.periods.mean()
    assert found_hz == pytest.approx(frequency_hz, rel=FREQUENCY_TOLERANCE)
    assert bench.outputs["fan"].driven


@pytest.mark.parametrize(
    ("board", "pins", "timer"), [("mega2560", ("D10", "D9"), 5), ("atmega32", ("PC0", "PC1"), 1)]
)
def test_two_on_one_timer_keep_apart(board: str, pins: tuple[str, str], timer: int) -> None:
    hot, part = f"{pins[0]}, frequency: 30 Hz", f"{pins[1]}, frequency: 122 Hz, active: low"
    bench = PwmBoard(placed(board, {"hot": hot, "part": part}))
    assert {channel.timer for channel in bench.channels.values()} == {timer}
    bench.ask("hot", 20.0)
    bench.ask("part", 70.0)
    for name, share in (("hot", 0.2), ("part", 0.7)):
        pulses = bench.seen(name, 1.0)
        assert abs(pulses.periods - bench.cycles_of(name)).max() <= 2 * LATENCY
        assert pulses.widths.mean() / pulses.periods.mean() == pytest.approx(share, abs=0.002)
    bench.ask("hot", 0.0)
    assert bench.seen("hot", 0.5).share == 0
    assert bench.seen("part", 0.5).share == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize(("board", "pin"), [("uno", "D4"), ("mega2560", "A8"), ("atmega32", "PC0")])
def test_an_interrupt_is_short(board: str, pin: str) -> None:
    """20 us at most with interrupts off."""
    bench = PwmBoard(placed(board, {"fan": f"{pin}, frequency: 490 Hz"}))
    profile = bench.avr.profile(bench.program)
    for percent in (3.0, 50.0, 97.0):
        bench.ask("fan", percent)
        bench.avr.run(0.1)
    longest = max(found.longest for name, found in profile.functions.items() if "vector" in name)
    assert longest / CLOCK_HZ < 20e-6
    assert profile.masked.seconds < 20e-6


@pytest.mark.parametrize("said", ["D4, frequency: 490 Hz", "D3, frequency: 976.5625 Hz"])
def test_nothing_is_wrong_with_a_heater(said: str) -> None:
    assert not any(heater_problems(placed("uno", {"heater": f"{said}, power: 40 W"})))


HEATERS = {
    "timer 2": ("uno", "D3", "976.5625 Hz"), "timer 1": ("nano", "D9", "1 kHz"),
    "timer 0": ("leonardo", "D3", "976.5625 Hz"), "timer 4": ("mega2560", "D8", "1 kHz"),
    "timer 3": ("atmega1284p", "PB6", "1 kHz"),
    "timer 0 of old": ("atmega32", "PB3", "976.5625 Hz"),
    "timer 1 of old": ("atmega16", "PD5", "1 kHz"),
    "timer 2 of old": ("atmega16", "PD7", "976.5625 Hz"),
    "interrupts": ("uno", "D4", "100 Hz"), "interrupts of old": ("atmega32", "PC0", "100 Hz"),
    "interrupts, far port": ("mega2560", "D9", "122 Hz"),
}  # fmt: skip


@pytest.mark.parametrize("name", HEATERS)
@either_level
def test_off_is_a_level_that_is_forced(name: str, active: str) -> None:
    """By the gate, by zero, and by the first instructions, with a reset or without one."""
    board, pin, frequency = HEATERS[name]
    said = f"{pin}, frequency: {frequency}, active: {active}, power: 40 W"
    place = placed(board, {"heater": said})
    text = sources_of(place.text)["reset.c"].partition("heaters_off")[2].partition("}")[0]
    lines = [line.strip() for line in text.splitlines()[2:]]
    # A pin that were driven first would be low for two cycles: on, where low is active.
    assert lines[-2:] == ["pin_output_heater_off();", "pin_output_heater_drive();"]
    assert ("TCCR" in lines[0]) == ("interrupts" not in name)
    bench = PwmBoard(place)
    assert gate_problem(bench) == ""
    bench.ask("heater", 60.0)
    assert bench.seen("heater", 0.1).share > 0.5
    assert reset_problem(bench, "heater") == ""
    assert restart_problem(bench) == ""
