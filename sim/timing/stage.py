"""The device whose timing is measured, with readings that keep display and lines busy."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from math import inf

from heatwright.sim.device import AvrDevice
from heatwright.spec import Controller, Loop, facts_of, full_a

SWING_K = 0.1
"""The readings alternate by this, mostly around a multiple of ten, so that all digits change."""


SLOWER, DEEPER, BOTTOM_S, DIPS = 4.0, 1.25, 1.0, 3
"""A dip of the reading: how much slower than `rise_rate`, how much deeper than a steady reading may
vary, the time at its bottom, and the number of dips in the time of the effort rules."""

STARTED_S = 1.5
"""When a loop is switched on: program and display have started by then."""
TO_SETPOINT = ("left", "select", "up", "select", "right", "left")
"""Keys in a menu: to the switch, on, back to the first screen, and to the setpoint."""
ABOVE_MINIMUM_K = 1.0
"""The machine is at least this much warmer than `protection.minimum`."""


@dataclass
class Beat:
    """An action, the time when it is next due, and its interval (inf: never again)."""

    due_s: float
    every_s: float
    act: Callable[[], object]


class Stage:
    """A device whose readings alternate once a period around the resting points of its loops.

    The temperatures stay so near to a setpoint that no rule trips. A switched loop is switched on;
    a heater's measured current follows the duty of the same period.
    """

    def __init__(self, controller: Controller, device: AvrDevice, lasts_s: float) -> None:
        """Prepare the readings; lasts_s -- length of the run, s."""
        self._device = device
        swings: dict[str, Beat] = {}
        self._beats: list[Beat] = []
        for name, loop in controller.loops.items():
            second = (controller.monitors[loop.also].sensor,) if loop.also else ()
            middle_c = resting_c(controller, name)
            for sensor in (loop.sensor, *second):
                averaged = controller.thermometers[sensor].moving_average
                dips_k = _dips(loop, middle_c, loop.periods_s(averaged), lasts_s)
                swing = _swing(device, sensor, middle_c, dips_k)
                swings[sensor] = _beat(loop, 0.0, swing)
            self._beats += _current(controller, device, loop)
            if facts_of(controller, name).switched:
                self._beats.append(Beat(STARTED_S, inf, partial(_start, controller, device, name)))
        self._beats += swings.values()
        self._act(0.0)  # the first reading may be soon after the power-on

    def advance(self, until_s: float) -> None:
        """Run to a time since power-on, s."""
        while (at_s := min(beat.due_s for beat in self._beats)) < until_s:
            self._device.advance(at_s)
            self._act(at_s)
        self._device.advance(until_s)

    def _act(self, at_s: float) -> None:
        for beat in self._beats:
            if beat.due_s <= at_s:
                beat.act()
                beat.due_s += beat.every_s


def _start(controller: Controller, device: AvrDevice, loop: str) -> None:
    """Switch the loop on, by its master, its keys, or its touch display.

    A menu then shows the screen of the setpoint. A loop that is already on needs no key: UP would
    change its setpoint.
    """
    facts, has_master = facts_of(controller, loop), facts_of(controller).modbus is not None
    if has_master:
        device.write(f"{loop}.enabled", True)
    if facts.keyed:
        if facts.programmed:
            device.shield.play(TO_SETPOINT)
        elif not has_master and not facts.starts_enabled:
            device.shield.play(("up",))
    elif not has_master and facts.touched:
        if facts.programmed:
            device.program("start", 1)
        else:
            device.send("#2 1;")


def _swing(
    device: AvrDevice, sensor: str, middle_c: float, dips_k: Sequence[float]
) -> Callable[[], None]:
    """Return a function that sets a sensor's next reading: the readings alternate, with dips."""
    sides, dip_k = cycle((SWING_K, -SWING_K)), cycle(dips_k)

    def swing() -> None:
        device.sense(sensor, middle_c + next(sides) - next(dip_k))

    return swing


def _dips(loop: Loop, middle_c: float, averaged_s: float, lasts_s: float) -> list[float]:
    """Return the reduction of the reading in each period from one dip to the next, K.

    There are dips only if rule effort_high or effort_low could trip during the measurement, as a
    steady reading needs some power. A dip is deep enough to count as movement, slower than
    `rise_rate`, and long enough to be read. Every other one is a rise: an on-off heater goes off
    again, and an integral does not grow. All are rises if a dip would last so long that heat
    without a rise is a fault; none is a rise if a rise without heat is a fault.
    """
    rules, effort = loop.protection, loop.protection.effort
    if effort is None or effort.for_s > lasts_s:
        return [0.0]
    room_k = min(middle_c - rules.minimum_c, rules.maximum_c - middle_c) - ABOVE_MINIMUM_K
    deep_k = min(DEEPER * effort.band.move_k + 3 * SWING_K, room_k)
    step_k = loop.rise_per_period_k / SLOWER
    way = max(1, math.ceil(deep_k / step_k))
    down = [deep_k * turn / way for turn in range(1, way + 1)]
    dip = [*down, *[deep_k] * math.ceil(loop.periods_in(BOTTOM_S)), *reversed(down)]
    gap_s = min(effort.for_s / DIPS, rules.heating.within_s / 2 if rules.heating else math.inf)
    between = [0.0] * max(1, int(loop.periods_in(gap_s)) - len(dip))
    rise = [*between, *(-each for each in dip)]
    dips_s = loop.periods_s(len(dip)) + averaged_s
    if rules.heating is not None and dips_s > rules.heating.within_s:
        return rise
    rising = rules.rising_while_off
    if rising is not None and deep_k + 2 * SWING_K >= rising.rise_k:
        return [*between, *dip]
    return [*between, *dip, *rise]


def _current(controller: Controller, device: AvrDevice, loop: Loop) -> list[Beat]:
    """Set the heater's current, if it is measured.

    The step at the beginning of a period sets the duty; it is read later in that period.
    """
    output = controller.switches[loop.heater]
    if output.current is None:
        return []
    sensor, whole_a = output.current.sensor, full_a(output) or 0.0

    def forget() -> None:
        device.on_fraction(loop.heater)

    def flow() -> None:
        device.sense(sensor, whole_a * device.on_fraction(loop.heater))

    return [_beat(loop, 0.25, forget), _beat(loop, 0.5, flow)]


def _beat(loop: Loop, share: float, act: Callable[[], object]) -> Beat:
    """Return a Beat that acts in each period of a loop, after a share of the period."""
    return Beat(loop.periods_s(share), loop.periods_s(1), act)


def resting_c(controller: Controller, loop: str) -> float:
    """Return the resting point of a loop: the multiple of ten nearest to its first setpoint, °C.

    It is always above `protection.minimum`. If the first step of a key would go above it, it is at
    that step, or as near as the rule runaway allows. A loop without keys rests at its setpoint:
    below, it might ask for full power permanently.
    """
    setpoint, protection = controller.loops[loop].setpoint, controller.loops[loop].protection
    low_c = max(setpoint.minimum_c, protection.minimum_c + ABOVE_MINIMUM_K)
    first_c = max(setpoint.initial_c, low_c)
    keypad = facts_of(controller).keypad
    if keypad is None or keypad.loop != loop:
        return first_c
    nearest_c = 10.0 * round(first_c / 10)
    resting = nearest_c if low_c <= nearest_c <= setpoint.maximum_c else first_c
    runaway = protection.runaway
    most_c = inf if runaway is None else setpoint.initial_c + runaway.above_k
    stepped_c = min(setpoint.minimum_c + keypad.step_k, setpoint.maximum_c)
    return max(resting, min(stepped_c, most_c - 2 * SWING_K))
