"""Timing of sensors: conversion and reading fit into a period, a restart into `stale_after`."""

from heatwright.spec.checks.finding import Finding, Findings, loop_sensors
from heatwright.spec.checks.loops.timing import restart_s
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import duration
from heatwright.spec.sensors import Thermometer, shortest_period_s


def conversion_fits(controller: Controller) -> Findings:
    """Check that the sensor's longest conversion (data sheet) and answer fit into the period."""
    for name, loop, sensor in loop_sensors(controller):
        needed_s = shortest_period_s(sensor)
        if not loop.has_time_for(needed_s):
            yield Finding(
                ("loops", name, "period"),
                f"{loop.told_period} is shorter than {_what_takes_so_long(sensor)}",
                f"Use at least {duration(needed_s)}{_or_less(sensor, loop.period_s)}",
                (("sensors", loop.sensor),),
            )


def _what_takes_so_long(sensor: Thermometer) -> str:
    took = duration(sensor.conversion_s)
    if sensor.on_adc:
        return f"the sensor's {sensor.oversample} readings, one every 10 ms, which take {took}"
    if not sensor.free_running_s:
        return f"a conversion ({took}) and the transfer of its result ({duration(sensor.read_s)})"
    more_s = sensor.read_s - sensor.conversion_s
    more = f", and {duration(more_s)} for the chip's self-test and answer" if more_s else ""
    return f"two conversions of {took}, of which the first may have begun before the step{more}"


def _or_less(sensor: Thermometer, period_s: float) -> str:
    """Return the remedy's alternative: settings of the sensor that fit into the period."""
    fitting = sensor.fitting(period_s)
    return f", or {fitting}" if fitting else ""


def first_reading_in_time(controller: Controller) -> Findings:
    """Check that `stale_after` outlasts a restart of the sensor, after its supply failed once."""
    for name, loop, sensor in loop_sensors(controller):
        needed_s = restart_s(sensor.first_s, loop)
        if sensor.first_s and loop.protection.stale_after_s < needed_s:
            yield Finding(
                ("loops", name, "protection", "stale_after"),
                f"after a brief loss of its supply {loop.sensor} may be without a reading for "
                f"{duration(needed_s)}: it needs {duration(sensor.first_s)}, and the loop's steps "
                f"take the rest; {duration(loop.protection.stale_after_s)} is shorter",
                f"Use at least {duration(needed_s)}",
                (("sensors", loop.sensor), ("loops", name, "period")),
            )
