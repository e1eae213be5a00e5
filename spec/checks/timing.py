"""Periods and time-outs: whole ticks, room for a conversion, counters that hold them."""

from __future__ import annotations

import math
from collections.abc import Iterator

from heatwright.spec.analog_sensors import AnalogSensor
from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.controller import WATCHDOG_S, Controller
from heatwright.spec.loops import Loop
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration
from heatwright.spec.sensors import Ds18b20, Sensor
from heatwright.spec.thermocouples import Max31855
from heatwright.spec.timers import TICK_S

MOST_STEPS = 65535
"""Steps a 16-bit counter holds."""

MOST_MISSING = 255
"""Missing readings an 8-bit counter holds."""

WATCHDOG_TOLERANCE = 0.1
"""The watchdog's own oscillator, 128 kHz nominal, varies so much with supply and temperature
(data sheets, typical characteristics)."""


def is_ticks(seconds: float) -> bool:
    """Tell whether a duration is a whole number of 10 ms ticks."""
    return round(seconds, 2) == seconds


def countable(controller: Controller) -> Iterator[tuple[str, Loop]]:
    """List the loops whose period is usable: the others' time-outs cannot be judged."""
    for name, loop in controller.loops.items():
        if is_ticks(loop.period_s) and loop.period_s <= MOST_STEPS * TICK_S:
            yield name, loop


def periods_are_ticks(controller: Controller) -> Findings:
    """Find periods that are no whole number of ticks, or too long to count."""
    for name, loop in controller.loops.items():
        path = ("loops", name, "period")
        if not is_ticks(loop.period_s):
            nearest = max(round(loop.period_s, 2), 0.01)
            yield Finding(
                path,
                f"{duration(loop.period_s)} is not a multiple of the 10 ms tick",
                f"Use {duration(nearest)}",
            )
        elif loop.period_s > MOST_STEPS * TICK_S:
            yield Finding(
                path, f"{duration(loop.period_s)} is too long to count", "Use at most 10 min"
            )


def conversion_fits(controller: Controller) -> Findings:
    """Hold the period to the sensor's longest conversion (data sheet) and its reading."""
    for name, loop, sensor in loop_sensors(controller):
        needed_s = shortest_period_s(sensor)
        if loop.period_s < needed_s:
            yield Finding(
                ("loops", name, "period"),
                f"{duration(loop.period_s)} is shorter than {_what_takes_so_long(sensor)}",
                f"Use at least {duration(needed_s)}{_or_less(sensor, loop.period_s)}",
                (("sensors", loop.sensor),),
            )


def shortest_period_s(sensor: Sensor) -> float:
    """Whole ticks for a conversion, and the reading."""
    return round(math.ceil(round(sensor.conversion_s / TICK_S, 6)) * TICK_S + sensor.read_s, 2)


def _what_takes_so_long(sensor: Sensor) -> str:
    took = duration(sensor.conversion_s)
    if isinstance(sensor, AnalogSensor):
        return f"its {sensor.oversample} readings, one each 10 ms, which take {took}"
    if isinstance(sensor, Max31855):
        return f"two conversions of {took}, of which the first may have begun before the step"
    return f"a conversion of {took} and its reading of {duration(sensor.read_s)}"


def _or_less(sensor: Sensor, period_s: float) -> str:
    """Tell what else would fit into a period."""
    if isinstance(sensor, AnalogSensor) and period_s >= TICK_S:
        return f", or oversample at most {math.floor(round(period_s / TICK_S, 6))}"
    if not isinstance(sensor, Ds18b20):
        return ""
    fitting = [
        bits
        for bits in (9, 10, 11)
        if shortest_period_s(sensor.model_copy(update={"resolution_bits": bits})) <= period_s
    ]
    return f", or a resolution of {fitting[-1]} bit" if fitting else ""


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
    if loop.autotune is not None:
        found["autotune", "timeout"] = loop.autotune.timeout_s
    return found


def time_outs_fit(controller: Controller) -> Findings:
    """Find time-outs shorter than a period, or too long for a 16-bit count of periods."""
    for name, loop in countable(controller):
        longest_s = MOST_STEPS * loop.period_s
        for inner, seconds in time_outs(loop).items():
            path = ("loops", name, *inner)
            because_of = (("loops", name, "period"),)
            if seconds < loop.period_s:
                yield Finding(
                    path,
                    f"{duration(seconds)} is shorter than the period of {duration(loop.period_s)}",
                    f"Use at least {duration(loop.period_s)}",
                    because_of,
                )
            elif seconds > longest_s:
                yield Finding(
                    path,
                    f"{duration(seconds)} is more than {MOST_STEPS} periods of "
                    f"{duration(loop.period_s)}",
                    f"Use at most {duration(longest_s)}, or a longer period",
                    because_of,
                )


def stale_after(controller: Controller) -> Findings:
    """Hold `stale_after` to two periods, for one reading may be lost, and to an 8-bit count."""
    for name, loop in countable(controller):
        path = ("loops", name, "protection", "stale_after")
        seconds = loop.protection.stale_after_s
        because_of = (("loops", name, "period"),)
        if seconds < 2 * loop.period_s:
            yield Finding(
                path,
                f"{duration(seconds)} is less than two periods of {duration(loop.period_s)}, so "
                "one lost reading would be a fault",
                f"Use at least {duration(2 * loop.period_s)}",
                because_of,
            )
        elif seconds > MOST_MISSING * loop.period_s:
            yield Finding(
                path,
                f"{duration(seconds)} is more than {MOST_MISSING} periods",
                f"Use at most {duration(MOST_MISSING * loop.period_s)}",
                because_of,
            )


def first_reading_in_time(controller: Controller) -> Findings:
    """Hold `stale_after` to the time that a sensor needs after the power-up."""
    for name, loop, sensor in loop_sensors(controller):
        needed_s = round(sensor.first_s + loop.period_s, 2)
        if sensor.first_s and loop.protection.stale_after_s < needed_s:
            yield Finding(
                ("loops", name, "protection", "stale_after"),
                f"{duration(loop.protection.stale_after_s)} is over before {loop.sensor} has its "
                f"first reading, {duration(sensor.first_s)} after the power-up, and a step sees it",
                f"Use at least {duration(needed_s)}",
                (("sensors", loop.sensor), ("loops", name, "period")),
            )


def watchdog_slow_enough(controller: Controller) -> Findings:
    """Hold the watchdog, at its shortest, to two ticks: it is reset once a tick."""
    watchdog_s = controller.safety.watchdog_s
    if watchdog_s * (1 - WATCHDOG_TOLERANCE) < 2 * TICK_S:
        able = [each for each in WATCHDOG_S if each * (1 - WATCHDOG_TOLERANCE) >= 2 * TICK_S]
        yield Finding(
            ("safety", "watchdog"),
            f"{duration(watchdog_s)} may be over, at its oscillator's tolerance of 10 %, before "
            "two ticks of 10 ms are",
            f"Use at least {duration(able[0])}",
        )


def watchdog_fast_enough(controller: Controller) -> Findings:
    """A hung program must not heat for longer than a lost sensor may."""
    watchdog_s = controller.safety.watchdog_s
    for name, loop in controller.loops.items():
        stale_s = loop.protection.stale_after_s
        if watchdog_s > stale_s:
            able = [each for each in WATCHDOG_S if each <= stale_s]
            yield Finding(
                ("safety", "watchdog"),
                f"{duration(watchdog_s)} would let a hung program heat for longer than a lost "
                f"sensor may in the loop {name} (stale_after: {duration(stale_s)})",
                f"Use at most {duration(able[-1])}" if able else "Lengthen stale_after",
                (("loops", name, "protection", "stale_after"),),
            )
