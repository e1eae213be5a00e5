"""Periods and time-outs: whole ticks, room for a conversion, counters that are wide enough."""

import math
from collections.abc import Iterator

from heatwright.spec.board.interrupts import longest_tick_s, waits
from heatwright.spec.board.timers import TICK_S
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import WATCHDOG_S, Controller
from heatwright.spec.loops import MOST_STEPS, Loop
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration, hertz

MOST_BUSES, QUICK_HZ = 4, 16_000_000
"""Maximum number of 1-Wire buses, measured, at this clock or a faster one; at a slower one 3."""

MOST_MISSING = 255
"""Maximum number of missing readings: an 8-bit counter counts them."""

WATCHDOG_TOLERANCE = 0.1
"""Deviation of the watchdog's own oscillator, 128 kHz nominal, with supply and temperature (data
sheets, typical characteristics)."""


def is_ticks(seconds: float) -> bool:
    """Return whether a duration is a whole number of 10 ms ticks."""
    return round(seconds, 2) == seconds


def periods_s(count: int, loop: Loop) -> float:
    """Return the time of a number of periods, s, without rounding errors: 181.05, not 181.0499."""
    return round(loop.periods_s(count), 2)


def restart_s(first_s: float, loop: Loop) -> float:
    """Return how long a loop has no reading, s, if its sensor restarts and needs `first_s` for it.

    One step finds that the reading is lost; the following steps have no reading until the first new
    one.
    """
    return periods_s(1 + max(1, math.ceil(round(loop.periods_in(first_s), 6))), loop)


def lasts_a_period(path: Path, seconds: float, name: str, loop: Loop, so: str = "") -> Findings:
    """Find a time that is shorter than a period; so -- the consequence, for the message."""
    if seconds < loop.period_s:
        yield Finding(
            path,
            f"{duration(seconds)} is shorter than the period of {loop.told_period}{so}",
            f"Use at least {loop.told_period}",
            (("loops", name, "period"),),
        )


def time_fits(path: Path, seconds: float, name: str, loop: Loop, most: int) -> Findings:
    """Find a time that is shorter than a period, or longer than the most that are counted."""
    yield from lasts_a_period(path, seconds, name, loop)
    if seconds > periods_s(most, loop):
        yield Finding(
            path,
            f"{duration(seconds)} is more than {most} periods of {loop.told_period}",
            f"Use at most {duration(periods_s(most, loop))}, or a longer period",
            (("loops", name, "period"),),
        )


def whole_ticks(path: Path, seconds: float) -> Findings:
    """Find a time that is no whole number of ticks."""
    if not is_ticks(seconds):
        nearest = duration(max(round(seconds, 2), TICK_S))
        reason = f"{duration(seconds)} is not a multiple of the 10 ms tick"
        yield Finding(path, reason, f"Use {nearest}")


def can_be_counted(path: Path, seconds: float) -> Findings:
    """Find a time with too many ticks for a 16-bit counter."""
    if seconds > MOST_STEPS * TICK_S:
        yield Finding(path, f"{duration(seconds)} is too long to count", "Use at most 10 min")


def counted_ticks(path: Path, seconds: float) -> Findings:
    """Find a time that is no whole number of ticks, or that has too many."""
    yield from (can_be_counted if is_ticks(seconds) else whole_ticks)(path, seconds)


def countable(controller: Controller) -> Iterator[tuple[str, Loop]]:
    """List the loops with a valid period: time-outs of the others cannot be checked."""
    for name, loop in controller.loops.items():
        if is_ticks(loop.period_s) and loop.period_s <= MOST_STEPS * TICK_S:
            yield name, loop


def periods_are_ticks(controller: Controller) -> Findings:
    """Find periods that are no whole number of ticks, or too long to count."""
    for name, loop in controller.loops.items():
        yield from counted_ticks(("loops", name, "period"), loop.period_s)


def time_outs(loop: Loop) -> dict[Path, float]:
    """List a loop's time-outs that are counted in steps, by their path inside the loop."""
    protection = loop.protection
    found: dict[Path, float] = {}
    if protection.heating is not None:
        found["protection", "heating", "within"] = protection.heating.within_s
    if protection.runaway is not None:
        found["protection", "runaway", "for"] = protection.runaway.for_s
    if protection.frozen is not None:
        found["protection", "frozen", "for"] = protection.frozen.for_s
    if protection.rising_while_off is not None:
        found["protection", "rising_while_off", "settle"] = protection.rising_while_off.settle_s
    if protection.agreement is not None:
        found["protection", "agreement", "for"] = protection.agreement.for_s
    if protection.effort is not None:
        found["protection", "effort", "for"] = protection.effort.for_s
    if loop.autotune is not None:
        found["autotune", "timeout"] = loop.autotune.timeout_s
    if loop.response is not None:
        found["response", "for"] = loop.response.for_s
    return found


def time_outs_fit(controller: Controller) -> Findings:
    """Find time-outs shorter than a period, or too long for a 16-bit count of periods."""
    for name, loop in countable(controller):
        for inner, seconds in time_outs(loop).items():
            yield from time_fits(("loops", name, *inner), seconds, name, loop, MOST_STEPS)


def stale_after(controller: Controller) -> Findings:
    """Check that `stale_after` lasts two periods, as a reading may be lost, and fits 8 bits."""
    for name, loop in countable(controller):
        path = ("loops", name, "protection", "stale_after")
        seconds = loop.protection.stale_after_s
        because_of = (("loops", name, "period"),)
        if seconds < periods_s(2, loop):
            yield Finding(
                path,
                f"{duration(seconds)} is less than two periods of {loop.told_period}, so "
                "one lost reading would be a fault",
                f"Use at least {duration(periods_s(2, loop))}",
                because_of,
            )
        elif seconds > periods_s(MOST_MISSING, loop):
            yield Finding(
                path,
                f"{duration(seconds)} is more than {MOST_MISSING} periods",
                f"Use at most {duration(periods_s(MOST_MISSING, loop))}",
                because_of,
            )


def watchdog_on_the_chip(controller: Controller) -> Findings:
    """Find times that are too long for the chip's watchdog: the oldest chips have at most 2 s."""
    board, watchdog_s = controller.board, controller.safety.watchdog_s
    if watchdog_s > board.longest_watchdog_s:
        yield Finding(
            ("safety", "watchdog"),
            f"the watchdog of the {board.mcu} cannot wait for {duration(watchdog_s)}",
            f"Use at most {duration(board.longest_watchdog_s)}",
            (("controller", "board"),),
        )


def watchdog_slow_enough(controller: Controller) -> Findings:
    """Check that the watchdog's shortest time is two ticks: the program resets it in each tick."""
    watchdog_s = controller.safety.watchdog_s
    if watchdog_s * (1 - WATCHDOG_TOLERANCE) < 2 * TICK_S:
        able = [each for each in WATCHDOG_S if each * (1 - WATCHDOG_TOLERANCE) >= 2 * TICK_S]
        yield Finding(
            ("safety", "watchdog"),
            f"a watchdog of {duration(watchdog_s)}, whose oscillator has a tolerance of 10 %, may "
            "reset the chip before two ticks of 10 ms are over",
            f"Use at least {duration(able[0])}",
        )


def watchdog_fast_enough(controller: Controller) -> Findings:
    """Check that a hung program cannot heat for longer than a loop with a lost sensor."""
    watchdog_s = controller.safety.watchdog_s
    longest_s = controller.board.longest_watchdog_s
    for name, loop in controller.loops.items():
        stale_s = loop.protection.stale_after_s
        if watchdog_s > stale_s:
            able = [each for each in WATCHDOG_S if each <= min(stale_s, longest_s)]
            yield Finding(
                ("safety", "watchdog"),
                f"{duration(watchdog_s)} would let a hung program heat for longer than a lost "
                f"sensor may in the loop {name} (stale_after: {duration(stale_s)})",
                f"Use at most {duration(able[-1])}" if able else "Lengthen stale_after",
                (("loops", name, "protection", "stale_after"),),
            )


def interrupts_are_short(controller: Controller) -> Findings:
    """Check that the tick's interrupt is short enough for the others, which wait until it ends."""
    tick_s = longest_tick_s(controller)
    least = min(waits(controller), key=lambda each: each.seconds)
    if tick_s > least.seconds:
        instead = f", or {least.instead}" if least.instead else ""
        yield Finding(
            ("loops",),
            f"the interrupt of the tick takes up to {1e6 * tick_s:.0f} µs with these loops at "
            f"{hertz(controller.board.clock_hz)}, and no interrupt may wait for longer than "
            f"{1e6 * least.seconds:.0f} µs: {least.what}",
            f"Use a faster clock or fewer loops{instead}",
            (("controller",), ("outputs",), ("interfaces",), ("safety",)),
        )


def buses_wait_for_each_other(controller: Controller) -> Findings:
    """Find 1-Wire buses beyond the possible number: their slots coincide, and wait for each other.

    With four buses at 16 MHz a written 0 keeps the line low for up to 107 µs, with five for 208 µs;
    a DS18B20 accepts 120 µs.
    """
    buses = [name for name, each in controller.sensors.items() if each.on_one_wire]
    quick = controller.board.clock_hz >= QUICK_HZ
    most = MOST_BUSES if quick else MOST_BUSES - 1
    for name in buses[most:]:
        faster = "" if quick else f", or a clock of {hertz(QUICK_HZ)}"
        yield Finding(
            ("sensors", name, "kind"),
            f"this is DS18B20 number {buses.index(name) + 1}, each has a bus of its own, and the "
            f"slots of more than {most} buses at {hertz(controller.board.clock_hz)} would wait for "
            "each other for longer than the sensor allows",
            f"Use a sensor of another kind{faster}",
            (("controller",), ("sensors",)),
        )
