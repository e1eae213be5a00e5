"""Faults at keypad, display and serial port: stuck keys, random presses, a loose plug, floods."""

import random
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, answer_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.fault import Act, Fault, Trip, harmless, tripping
from heatwright.sim.faults.operation import hosts
from heatwright.sim.faults.operation.hands import SETPOINT
from heatwright.sim.faults.sensing.readings import SENSOR_RULES
from heatwright.sim.faults.site import OfState
from heatwright.sim.faults.world import Site, World
from heatwright.sim.interfaces.lcd_keypad.keypad import CODES
from heatwright.sim.trace import StepLog
from heatwright.spec import facts_of

SEED = 2
WATCH_S = 60.0
RESYNC_S = 32.0
"""The firmware sets the display up again every 30 s, in less than a second."""
FLOOD_BAUD = 115200
FLOOD_BYTES = 100_000
PRESSES = 60
LEAKS_S = 60.0
LEAK_DWELLS_S = (0.02, 0.05, 0.1, 0.3, 0.8)
JITTER_S = 0.001


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of the controller's interfaces."""
    if site.has_keys:
        yield from _keys(site)
        yield harmless(site, "display_unplugged", _unplug_and_plug, RESYNC_S, _shows_again)
    if site.facts.hosted:
        yield from hosts.faults(site)
    if site.controller.board.uarts:
        flood = harmless(site, "serial_flood", _flood, WATCH_S, keeps_time)
        yield replace(flood, may=("master_lost",))


def _keys(site: Site) -> Iterator[Fault]:
    yield harmless(site, "key_stuck", hold("down"), WATCH_S, _one_step)
    yield harmless(site, "keys_at_random", _play, WATCH_S)
    countdown = site.facts.countdown
    if countdown is not None:
        ends = harmless(site, "countdown_ends", _set_time, countdown.step_s, _goes_off_in_time)
        yield replace(ends, make=lambda: starts.held(site))
    trip = Trip(SENSOR_RULES, answer_s(site.loop))

    def cause(world: World) -> None:
        hold("select")(world)
        memory.cut_line(world)

    def cure(world: World) -> None:
        memory.mend_line(world)
        world.device.press(None)

    yield replace(tripping(site, "select_stuck", cause, trip, cure), sensor_lies=True)
    leaks = tripping(site, "select_leaks", _leak, trip, memory.mend_line)
    yield replace(leaks, sensor_lies=True, judge=_acknowledged_once)


def _leak(world: World) -> None:
    """Let SELECT and UP make bad contact while the sensor is cut off: neither may acknowledge."""
    world.device.shield.keypad.flicker(("select", "up"), LEAK_DWELLS_S, LEAKS_S)
    world.run(1.0)
    memory.cut_line(world)
    world.run(LEAKS_S)


def _acknowledged_once(world: World) -> str:
    """Check that only the press at the end of the trial has acknowledged."""
    times = sum(not each.code for each in world.trips.changes)
    return "" if times <= 1 else f"the leaking key acknowledged {times - 1} times"


def hold(key: str) -> Act:
    """Hold a key down."""
    return lambda world: world.device.press(key)


def _set_time(world: World) -> None:
    """Set the shortest time of the timer, and go back to the setpoint's page."""
    for key in ("right", "up", "right"):
        world.press(key)


def _goes_off_in_time(world: World) -> str:
    """Check that the loop goes off after the timer's time near its setpoint, and stays off."""
    if world.now_s - _last_on_s(world) > world.site.loop.periods_s(2):
        return f"the loop went off at {_last_on_s(world):.1f} s, too soon"
    if not world.until(OfState(lambda now: not now.loop("enabled")), starts.LONGEST_S):
        return "the loop is still on after its time"
    went_s = world.now_s
    world.run(WATCH_S)
    last_s = world.heater.last_on_s(went_s)
    return "" if last_s is None else f"the heater was on again at {last_s:.1f} s"


def _last_on_s(world: World) -> float:
    log = world.device.steps(world.site.loop_name)
    return float(log["time_s"][log["enabled"] > 0][-1])


def _one_step(world: World) -> str:
    """Check that a stuck DOWN counts as one press, or as none on a menu's first screen.

    The last step before the lowest setpoint may be shorter. There DOWN switches the loop off,
    which is a setpoint of 0 for a host.
    """
    site, before_c = world.site, starts.highest_c(world.site)
    lowest_c, expected_c = site.loop.setpoint.minimum_c, before_c
    if not site.has_menu and site.key_step_k:
        if before_c > lowest_c + starts.SINGLE_K:
            expected_c = max(lowest_c, before_c - site.key_step_k)
        elif site.facts.hosted:
            expected_c = 0.0
    return starts.setpoint_moved(world, expected_c)


def _play(world: World) -> None:
    """Press keys at random."""
    chance = random.Random(SEED)  # noqa: S311 - random touches, not a secret
    keys = tuple(key for key in CODES if key)
    for _ in range(PRESSES):
        world.press(chance.choice(keys))
        world.run(chance.choice((0.0, 0.5, 3.0)))


def _unplug_and_plug(world: World) -> None:
    lcd = world.device.shield.lcd
    lcd.unplug(world.now_s)
    world.run(3.0)
    world.device.feed()
    lcd.plug(world.now_s)


def _shows_again(world: World) -> str:
    """Check that the display shows both lines again, and that no control step waited for it."""
    first, second = world.read_display()
    controller, keypad = world.site.controller, facts_of(world.site.controller).keypad
    if keypad is not None and facts_of(controller, keypad.loop).programmed:
        on = "on" if world.device.steps(keypad.loop)["enabled"][-1] else "off"
        shows = " >" in first and second.split()[:1] == [on]  # a monitor's warning may follow
    else:
        shows = first.startswith("T=") and second.startswith(SETPOINT)
    if not shows:
        return f"the display shows {first!r} and {second!r}"
    return keeps_time(world)


def _flood(world: World) -> None:
    """Send bytes to the serial port without a pause."""
    noise = random.Random(SEED)  # noqa: S311 - noise, not a secret
    device = world.device
    device.avr.uarts[device.uart].send(noise.randbytes(FLOOD_BYTES), FLOOD_BAUD)


def keeps_time(world: World) -> str:
    """Check that every control step was in time."""
    late_s = off_s(world.device.steps(world.site.loop_name), world.site.loop.periods_s(1))
    return "" if late_s < JITTER_S + TICK_S else f"a step was {late_s * 1000:.1f} ms early or late"


def off_s(log: StepLog, period_s: float) -> float:
    """Return how far a step was at most from the time grid that starts at the first step, s.

    Differences between rows wrap like the counter, so it may wrap several times in the log.
    """
    since = np.cumsum(np.diff(log["steps"], prepend=log["steps"][:1]), dtype=np.int64)
    return float(np.abs(log["time_s"] - log["time_s"][0] - period_s * since).max())
