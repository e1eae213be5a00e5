"""Pulse width at the pins: what was seen of an output, and what is wrong with a heater's pulses."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rig.outputs import TICK_S, OutputBoard, Outputs, Wired, wired

from heatwright.sim.elf import Elf
from heatwright.spec.pwm import LATEST_INTERRUPT_S
from heatwright.spec.pwm_timers import PwmChannel
from heatwright.spec.timers import allocate

CLOCK_HZ = 16_000_000
TCCR2A, TIMSK1 = 0xB0, 0x6F
LATENCY = 200
"""Cycles: from the match to the pin. Its own interrupt, and the tick's before it."""
INSTRUCTION = 12
"""Cycles: the simulator moves a timer's pin after an instruction, or after the 8 cycles in which
the processor wakes and enters an interrupt."""


class Pulses(NamedTuple):
    """What was seen of an output, in cycles of the processor."""

    periods: NDArray[np.int64]
    """From one beginning to the next."""
    widths: NDArray[np.int64]
    """Of whole pulses."""
    share: float
    """Of the time that it was on."""


class PwmBoard(OutputBoard):
    """A board with such outputs."""

    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        super().__init__(place, elf)
        self.channels: dict[str, PwmChannel] = dict(allocate(self.controller).pwm)
        self.avr.run(0.05)

    def ask(self, name: str, percent: float) -> None:
        """Ask for a share, and wait until it is there."""
        super().ask(name, percent)
        self.avr.run(0.03 + 2 / self.channels[name].frequency_hz)

    def seen(self, name: str, seconds: float) -> Pulses:
        """Run on and look at an output."""
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
        begins_whole = begins[begins < ends[-1]] if len(ends) else begins[:0]
        widths = ends[np.searchsorted(ends, begins_whole)] - begins_whole
        return Pulses(np.diff(begins), widths, share)

    def cycles_of(self, name: str) -> int:
        """Cycles of a period, as the allocation says."""
        return self.channels[name].prescaler * self.channels[name].counts

    def late(self, name: str) -> int:
        """Cycles that an edge may be late."""
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


def pwm(board: str = "uno", **outputs: str) -> PwmBoard:
    """Put outputs, each a pin and what the file says of it, on a board."""
    return PwmBoard(placed(board, outputs))


def placed(board: str, outputs: Outputs) -> Wired:
    """Say where outputs are, each of which begins with its pin."""
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
    for counts, share in ((0, 0.0), (1, 0.0), (least - 1, 0.0), (least, None)):
        for asked, due in ((counts, share), (channel.counts - counts, share)):
            bench.ask("heater", asked * percent)
            seen = bench.seen("heater", 0.1)
            on = float(asked > least) if due is not None else None
            if on is not None and seen.share != on:
                yield f"{asked} counts are {seen.share}"
            if on is None and not 0 < seen.share < 1:
                yield f"{asked} counts, enough for an interrupt, are {seen.share}"


def gate_problem(bench: PwmBoard) -> str:
    """Say whether the gate does not force it off, or an order opens it."""
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
    for deaf_us, percent in ((300, 50.0), (1800, 97.0), (1800, 3.0)):
        bench.put("deaf_us", deaf_us)
        bench.ask("heater", percent)
        widths = bench.seen("heater", 20.0).widths
        whole, late = bench.cycles_of("heater"), deaf_us * 16
        pulse = percent / 100 * whole
        # Who sleeps through a pause goes on with the next pulse.
        most = pulse + (late if late < whole - pulse else whole) + 2 * LATENCY
        if not len(widths) or widths.max() > most:
            yield f"a pulse of {max(widths, default=0)} cycles, {most} at most"


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
