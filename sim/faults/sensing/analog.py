"""Faults of a sensor on the ADC: its wires, its contacts, the converter itself."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np

from heatwright.sim.circuits import Wiring, shares
from heatwright.sim.circuits.elements import element_ohm
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.machine import sensor_step_k, watch_s
from heatwright.sim.faults.sensing.readings import bursts, no_reading
from heatwright.sim.faults.world import Site, World
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.adc_sensor import AdcSensor
from heatwright.spec import Analog, Rtd, Thermistor

WATCH_S = 60.0
CODES = 1024
SOUND_PER_BROKEN = 4
"""An intermittent wire is sound for so many times as long as it is broken: the machine holds."""
COLDEST_C, HOTTEST_C = -200.0, 800.0
"""No sensor is asked to be beyond these."""


def cut(world: World) -> None:
    """Short the element."""
    _wire(Wiring(shorted=True))(world)


def mend(world: World) -> None:
    """Let its wires be as they were."""
    _wire(Wiring())(world)


def faults(site: Site) -> Iterator[Fault]:
    """Yield what applies to the loop's sensor."""
    yield from _broken(site)
    yield from _beyond_the_table(site)
    yield from _converter(site)
    yield from _contacts(site)


def _sensor(site: Site) -> Thermistor | Rtd | Analog:
    return cast("Thermistor | Rtd | Analog", site.controller.sensors[site.loop.sensor])


def _wire(wiring: Wiring) -> Act:
    def act(world: World) -> None:
        tip = cast("AdcSensor", world.device.sensors[world.site.loop.sensor])
        tip.wiring = wiring

    return act


def _broken(site: Site) -> Iterator[Fault]:
    """A wire is broken, or the two touch: the circuit goes to its own limits."""
    sound = _wire(Wiring())
    yield no_reading(site, "open", _wire(Wiring(opened=True)), sound)
    yield no_reading(site, "shorted", _wire(Wiring(shorted=True)), sound)


def _beyond_the_table(site: Site) -> Iterator[Fault]:
    """The tip is a little beyond an end of the range: no table goes on there."""
    coldest_c, hottest_c = _sensor(site).range_c
    for name, end_c, away_c in (
        ("beyond_the_cold_end", coldest_c, COLDEST_C),
        ("beyond_the_hot_end", hottest_c, HOTTEST_C),
    ):
        beyond_c = _next_codes_c(site, end_c, away_c)
        yield no_reading(site, name, _feel(site, beyond_c), _feel_again(site))


def _next_codes_c(site: Site, end_c: float, away_c: float) -> float:
    """Return a temperature whose code is the second one beyond that of the range's end."""
    sensor, board = _sensor(site), site.controller.board
    away = np.linspace(end_c, away_c, 100_000)
    codes = np.floor(CODES * shares(sensor, board, away))
    return float(away[np.argmax(np.abs(codes - codes[0]) >= 2)])


def _feel(site: Site, tip_c: float) -> Act:
    def cause(world: World) -> None:
        world.wiring.feel[site.loop.sensor] = lambda _: tip_c

    return cause


def _feel_again(site: Site) -> Act:
    def cure(world: World) -> None:
        world.wiring.feel.pop(site.loop.sensor)

    return cure


def _converter(site: Site) -> Iterator[Fault]:
    """The ADC no longer ends its conversions, or ends each with the channel's last code.

    Keys are on the same ADC: whoever has them cannot acknowledge until it is well again.
    """
    hangs = no_reading(site, "adc_hangs", _fail(hung=True), _fail())
    others = _others_on_the_adc(site)
    yield replace(hangs, current_lies=True, again=not site.has_keys, others_lie=others)
    yield Fault(
        "adc_stuck",
        lambda: starts.heating(site),
        _fail(stuck=True),
        _fail(),
        watch_s=watch_s(site),
        sensor_lies=True,
        others_lie=others,
        current_lies=True,
        again=not site.has_keys,
    )


def _others_on_the_adc(site: Site) -> tuple[str, ...]:
    controller = site.controller
    found = {
        name: loop.sensor for name, loop in controller.loops.items() if name != site.loop_name
    } | {f"monitor_{name}": monitor.sensor for name, monitor in controller.monitors.items()}
    return tuple(name for name, sensor in found.items() if controller.thermometers[sensor].on_adc)


def _fail(*, hung: bool = False, stuck: bool = False) -> Act:
    return lambda world: world.device.avr.adc.fail(hung=hung, stuck=stuck)


def _contacts(site: Site) -> Iterator[Fault]:
    """A wire that is broken now and then; contacts and insulation that spoil the resistance."""
    most = steps(site.loop.protection.stale_after_s, site.loop) - 2
    if most > 0:
        turn = (1 + SOUND_PER_BROKEN) * most
        yield bursts(
            site,
            "intermittent_wire",
            _now_and_then(site, most, turn),
            _sound_again,
            max(WATCH_S, site.loop.periods_s(turn)),
        )
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
    """Have the circuit see the element that far away that it would move at twice the allowed rate.

    which -- of the resistances there, hotter and colder, the one it sees; wiring -- from the
    element's own resistance and that one.
    """

    def cause(world: World) -> None:
        jump_k = 2 * site.loop.rise_per_period_k + 2 * sensor_step_k(site)
        around_c = world.tip_c + np.array([0.0, jump_k, -jump_k])
        here_ohm, *there_ohm = element_ohm(sensor, np.maximum(around_c, COLDEST_C)).tolist()
        _wire(wiring(here_ohm, which(there_ohm)))(world)

    return Fault(
        name,
        lambda: starts.heating(site),
        cause,
        _wire(Wiring()),
        trip=Trip((), answer_s(site.loop)),  # as far as that the reading may be none at all
        sensor_lies=True,
    )


def _now_and_then(site: Site, broken: int, turn: int) -> Act:
    """Break the wire for so many of a turn's periods, again and again."""

    def cause(world: World) -> None:
        began_s = world.now_s

        def feel(felt_c: float) -> float:
            now = site.loop.periods_in(world.now_s - began_s) % turn
            _wire(Wiring(opened=now < broken))(world)
            return felt_c

        world.wiring.feel[site.loop.sensor] = feel

    return cause


def _sound_again(world: World) -> None:
    _feel_again(world.site)(world)
    mend(world)
