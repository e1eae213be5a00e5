"""Faults of a sensor on the ADC: its wires, its contacts, and the ADC itself."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from heatwright.sim.circuits import Wiring, shares
from heatwright.sim.circuits.elements import element_ohm
from heatwright.sim.faults.bounds import answer_s
from heatwright.sim.faults.effects import Felt, standing
from heatwright.sim.faults.fault import Act, Fault, Trip, tripping, watched
from heatwright.sim.faults.machine import sensor_step_k
from heatwright.sim.faults.sensing.readings import bursts, no_reading
from heatwright.sim.faults.world import Site, World
from heatwright.sim.machine import Feel
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.adc_sensor import AdcSensor, curve_of
from heatwright.spec import Analog, Rtd, Thermistor

KINDS = ("analog", "rtd", "thermistor")
"""The kinds of sensors that this module serves (spec/registry.py)."""
WATCH_S = 60.0
CODES = 1024
SOUND_PER_BROKEN = 4
"""An intermittent wire is sound this many times as long as broken, so the machine keeps warm."""
COLDEST_C, HOTTEST_C = -200.0, 800.0
"""No sensor is simulated beyond these temperatures, or beyond the curve of its circuit."""


def cut(world: World) -> None:
    """Short the element."""
    _wire(Wiring(shorted=True))(world)


def mend(world: World) -> None:
    """Repair the wires."""
    _wire(Wiring())(world)


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's sensor on the ADC."""
    yield from _broken(site)
    yield from _beyond_the_table(site)
    yield from _converter(site)
    yield from _contacts(site)


def _sensor(site: Site) -> Thermistor | Rtd | Analog:
    return cast("Thermistor | Rtd | Analog", site.controller.sensors[site.loop.sensor])


def _wire(wiring: Wiring) -> Act:
    def act(world: World) -> None:
        cast("AdcSensor", world.device.sensors[world.site.loop.sensor]).wiring = wiring

    return act


def _broken(site: Site) -> Iterator[Fault]:
    """Yield a broken wire, and two wires that touch: the voltage goes to one of its limits."""
    sound = _wire(Wiring())
    yield no_reading(site, "open", _wire(Wiring(opened=True)), sound)
    yield no_reading(site, "shorted", _wire(Wiring(shorted=True)), sound)


def _beyond_the_table(site: Site) -> Iterator[Fault]:
    """Yield a tip just beyond either end of the sensor's table, where its voltage still changes."""
    sensor = _sensor(site)
    curve, (coldest_c, hottest_c) = curve_of(sensor, Wiring()), sensor.range_c
    for name, end_c, away_c in (
        ("beyond_the_cold_end", coldest_c, min(COLDEST_C, curve.first)),
        ("beyond_the_hot_end", hottest_c, max(HOTTEST_C, curve.last)),
    ):
        next_c = _next_codes_c(site, end_c, away_c)
        if next_c is not None:
            beyond = Felt(site.loop.sensor, standing(next_c))
            yield no_reading(site, name, beyond, beyond.mend)


def _next_codes_c(site: Site, end_c: float, away_c: float) -> float | None:
    """Return a temperature whose ADC code is two beyond that of the range's end, or None."""
    sensor, board = _sensor(site), site.controller.board
    away = np.linspace(end_c, away_c, 100_000)
    codes = np.floor(CODES * shares(sensor, board, away))
    beyond = np.abs(codes - codes[0]) >= 2
    return float(away[np.argmax(beyond)]) if beyond.any() else None


def _converter(site: Site) -> Iterator[Fault]:
    """Yield an ADC that no longer ends its conversions, and one that repeats each channel's code.

    The keys are on the same ADC: they cannot acknowledge until it works again.
    """
    hangs = no_reading(site, "adc_hangs", _fail(hung=True), _fail())
    stuck = replace(watched(site, "adc_stuck", _fail(stuck=True), _fail()), sensor_lies=True)
    others, again = _others_on_the_adc(site), not site.has_keys
    for fault in (hangs, stuck):
        yield replace(fault, current_lies=True, again=again, others_lie=others)


def _others_on_the_adc(site: Site) -> tuple[str, ...]:
    controller = site.controller
    found = {
        name: loop.sensor for name, loop in controller.loops.items() if name != site.loop_name
    } | {f"monitor_{name}": monitor.sensor for name, monitor in controller.monitors.items()}
    return tuple(name for name, sensor in found.items() if controller.thermometers[sensor].on_adc)


def _fail(*, hung: bool = False, stuck: bool = False) -> Act:
    return lambda world: world.device.avr.adc.fail(hung=hung, stuck=stuck)


def _contacts(site: Site) -> Iterator[Fault]:
    """Yield an intermittent wire, and bad contacts and insulation that change the resistance."""
    most = steps(site.loop.protection.stale_after_s, site.loop) - 2
    if most > 0:
        yield _intermittent(site, most)
    sensor = _sensor(site)
    if not sensor.gives_voltage:
        jump = partial(_jump, site, sensor)
        yield jump("contact_corrodes", max, lambda ohm, seen: Wiring(series_ohm=seen - ohm))
        yield jump(
            "insulation_leaks", min, lambda ohm, seen: Wiring(parallel_ohm=1 / (1 / seen - 1 / ohm))
        )


def _jump(
    site: Site,
    sensor: Thermistor | Rtd,
    name: str,
    which: Callable[[list[float]], float],
    wiring: Callable[[float, float], Wiring],
) -> Fault:
    """Return a resistance that makes the reading jump by twice what `rise_rate` allows.

    which -- selects the element's resistance after a jump up or down; wiring -- returns the wiring
    for the element's resistances before and after the jump, Ω.
    """

    def cause(world: World) -> None:
        jump_k = 2 * site.loop.rise_per_period_k + 2 * sensor_step_k(site)
        around_c = world.tip_c + np.array([0.0, jump_k, -jump_k])
        here_ohm, *there_ohm = element_ohm(sensor, np.maximum(around_c, COLDEST_C)).tolist()
        _wire(wiring(here_ohm, which(there_ohm)))(world)

    trip = Trip((), answer_s(site.loop))  # after such a jump there may be no reading
    return replace(tripping(site, name, cause, trip, _wire(Wiring())), sensor_lies=True)


def _intermittent(site: Site, broken: int) -> Fault:
    """Return a wire that is broken for this number of periods, again and again."""
    turn = (1 + SOUND_PER_BROKEN) * broken

    def by_turns(world: World) -> Feel:
        began_s = world.now_s

        def feel(felt_c: float) -> float:
            now = site.loop.periods_in(world.now_s - began_s) % turn
            _wire(Wiring(opened=now < broken))(world)
            return felt_c

        return feel

    def cure(world: World) -> None:
        breaks.mend(world)
        mend(world)

    breaks = Felt(site.loop.sensor, by_turns)
    for_s = max(WATCH_S, site.loop.periods_s(turn))
    return bursts(site, "intermittent_wire", breaks, cure, for_s)
