"""Faults of a DS18B20: its cable, its supply and its conversions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import cast

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import answer_s
from heatwright.sim.faults.fault import Act, Fault, Trip
from heatwright.sim.faults.machine import watch_s
from heatwright.sim.faults.sensing.readings import (
    DAMAGED_ANSWERS,
    SENSOR_RULES,
    bursts,
    no_reading,
    slow_conversions,
)
from heatwright.sim.faults.world import Site, Weather, World
from heatwright.sim.reference.numbers import steps
from heatwright.sim.sensors.ds18b20 import Ds18b20

WATCH_S = 120.0


def cut(world: World) -> None:
    """Short the line to ground."""
    _chip(world).short("low")


def mend(world: World) -> None:
    """Remove the short."""
    _chip(world).short(None)


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the loop's DS18B20."""
    yield from _answers(site)
    yield from _frozen(site)
    yield from _never_converts(site)
    yield from _harmless(site)


def _chip(world: World) -> Ds18b20:
    return cast("Ds18b20", world.device.sensors[world.site.loop.sensor])


def _on_chip(act: Callable[[Ds18b20], None]) -> Act:
    return lambda world: act(_chip(world))


def _answers(site: Site) -> Iterator[Fault]:
    """Yield a chip without an answer or with bad ones: the heater goes off at the first one."""
    cases: tuple[tuple[str, Act, Act], ...] = (
        ("unplugged", _on_chip(Ds18b20.unplug), _on_chip(Ds18b20.plug)),
        ("shorted_to_ground", _short("low"), _short(None)),
        ("shorted_to_supply", _short("high"), _short(None)),
        ("damaged_answers", _corrupt(1.0), _corrupt(0.0)),
        ("failing_supply", _weak(on=True), _weak(on=False)),
    )
    for name, cause, cure in cases:
        yield no_reading(site, name, cause, cure)


def _short(level: str | None) -> Act:
    return _on_chip(lambda chip: chip.short(level))


def _corrupt(rate: float) -> Act:
    def act(chip: Ds18b20) -> None:
        chip.faults.corrupt_rate = rate

    return _on_chip(act)


def _freeze(*, on: bool) -> Act:
    def act(chip: Ds18b20) -> None:
        chip.faults.frozen = on

    return _on_chip(act)


def _never_converting(chip: Ds18b20) -> None:
    """Reset the chip to its power-on value, and stop its conversions."""
    chip.faults.idle = True
    chip.brown_out()


def _converting(chip: Ds18b20) -> None:
    chip.faults.idle = False


def _weak(*, on: bool) -> Act:
    def act(chip: Ds18b20) -> None:
        chip.faults.weak = on

    return _on_chip(act)


def _bursts(world: World) -> None:
    """Damage as many answers in a row as the controller just tolerates, again and again."""
    most = steps(world.site.loop.protection.stale_after_s, world.site.loop) - 1

    def damage(chip: Ds18b20) -> None:
        chip.faults.corrupt_next = most

    _every(world, most + 2, damage)


def _bursts_end(world: World) -> None:
    world.wiring.feel.pop(world.site.loop.sensor)
    _chip(world).faults.corrupt_next = 0


def _every(world: World, periods: int, act: Callable[[Ds18b20], None]) -> None:
    """Call `act` with the chip once every `periods` control periods."""
    every_s = world.site.loop.periods_s(periods)
    turn = int(world.now_s / every_s)

    def feel(felt_c: float) -> float:
        nonlocal turn
        now = int(world.now_s / every_s)
        if now != turn:
            act(_chip(world))
        turn = now
        return felt_c

    world.wiring.feel[world.site.loop.sensor] = feel


def _frozen(site: Site) -> Iterator[Fault]:
    """Yield a chip that repeats its present reading permanently, while the machine heats."""
    yield Fault(
        "frozen",
        lambda: starts.heating(site),
        _freeze(on=True),
        _freeze(on=False),
        watch_s=watch_s(site),
        sensor_lies=True,
        again=True,
    )


def _never_converts(site: Site) -> Iterator[Fault]:
    """Yield a chip that answers its power-on value from the start, with a correct CRC."""
    yield Fault(
        "never_converts",
        lambda: World(site, Weather(starts.ambient_c(site), starts.ambient_c(site))),
        _on_chip(_never_converting),
        _on_chip(_converting),
        trip=Trip(SENSOR_RULES, answer_s(site.loop)),
        sensor_lies=True,
        again=True,
        judge=_never_believed,
    )


def _harmless(site: Site) -> Iterator[Fault]:
    """Yield disturbances such as a long cable causes, which must not trip a rule of the sensor."""
    yield bursts(site, DAMAGED_ANSWERS, _bursts, _bursts_end, WATCH_S)
    yield Fault(
        "supply_interrupted_once",
        lambda: starts.heating(site),
        _on_chip(Ds18b20.brown_out),
        calm=True,
        watch_s=WATCH_S,
        judge=_never_believed,
    )

    def slow(chip: Ds18b20) -> None:
        chip.faults.slow = 1.5

    yield slow_conversions(site, _on_chip(slow), WATCH_S)


def _never_believed(world: World) -> str:
    """Check that the chip's power-on value was never used as a temperature."""
    log = world.device.steps(world.site.loop_name)
    highest_c = float(log["temperature_c"].max())
    sensor = world.site.controller.thermometers[world.site.loop.sensor]
    may_k = world.site.loop.protection.rise_rate_k_per_s + sensor.step_k
    if highest_c > world.peak_c + may_k:
        return f"the power-on value {highest_c:.1f} °C was used as a temperature"
    return ""
