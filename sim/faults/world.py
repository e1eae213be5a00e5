"""A binary on its machine, of which any part can be broken."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.coupling import Coupling, metered_step_s, sums_noise
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults.bears import bears_c
from heatwright.sim.faults.operation.hands import hand_of, release
from heatwright.sim.faults.peaks import Peaks
from heatwright.sim.faults.records import HeaterLog, TripLog
from heatwright.sim.faults.site import OfState, Site
from heatwright.sim.machine import (
    BITS,
    NO_STOP,
    SENSED,
    TIME,
    TIPS,
    Beside,
    Feel,
    Heat,
    Machine,
    Stop,
)
from heatwright.sim.plants import plant_of, profile_c
from heatwright.sim.plants.thermal_network import Plant
from heatwright.sim.reference.outputs.output import heater_of
from heatwright.sim.scenario import PRESS_S, Action
from heatwright.spec import ThermalNetwork, facts_of
from heatwright.spec.board.timers import TICK_S

STEP_S = 0.1
"""Longest time step of the machine; a tenth of the usual control period."""
ROUNDING = 1e-6
ANSWER_S = 1.0
ANSWER_CHARACTERS = 2048
CHARACTER_BITS = 11
"""A host has its answer within ANSWER_S plus the time of this number of characters, if the line
works: earlier questions are answered first."""

Condition = Callable[["World"], bool]


@dataclass(frozen=True)
class Known:
    """A condition that C can test, too: `stop` returns the `Stop` that ends a run if it is met."""

    holds: Condition
    stop: Callable[[World], Stop]

    def __call__(self, world: World) -> bool:
        """Return whether the condition holds now."""
        return self.holds(world)


def below(limit_c: float) -> Known:
    """Return the condition that the machine is colder at the loop's sensor than a limit, °C."""
    return Known(
        lambda world: world.sensed_c < limit_c,
        lambda world: Stop(below=(world.site.loop.sensor, limit_c)),
    )


SPREAD = Known(lambda world: not world.peaks.spreads, lambda _: Stop(spread=True))
"""Without power from any heater, no node becomes hotter any more."""


def given(site: Site) -> Known:
    """Return the condition that the loop's heater has an on-time above 0.

    A duty below the shortest pulse results in no on-time.
    """
    heater = site.loop.heater
    members = heater_of(site.controller, heater).members
    variable = (
        f"output_{heater}.{members[0][0]}" if members else f"loop_{site.loop_name}.duty_percent"
    )
    return Known(
        lambda world: bool(world.device.read(variable) > 0),
        lambda world: Stop(changed=(world.device.variables[variable],)),
    )


def switched(*, on: bool) -> Known:
    """Return the condition that the pin of the loop's heater is at its active level, or is not."""
    return Known(
        lambda world: world.device.outputs[world.site.loop.heater].on == on,
        lambda world: Stop(turned=world.site.loop.heater),
    )


@dataclass(frozen=True)
class Weather:
    """The machine at the start: temperatures of the loop's sensor and of the ambient, °C.

    The machine has settled there. Nodes of other loops are at the ambient temperature.
    """

    start_c: float
    ambient_c: float
    network: ThermalNetwork | None = None
    """The machine, if it is not that of the spec."""
    seed: int = 0


Spoilt = tuple[dict[str, Heat], dict[str, Beside], dict[str, Feel], float, dict[str, float]]


@dataclass
class Wiring:
    """The connections between controller and machine, which can break.

    heat -- by output: changes its power. besides -- by output: an additional source of heat at its
    node. feel -- by sensor: from the machine's temperature to the tip's, °C. volts -- voltage of
    the heaters' supply, as a share of the nominal one; taken -- by output: the share of its power
    that something takes away at its node.
    """

    heat: dict[str, Heat] = field(default_factory=dict)
    besides: dict[str, Beside] = field(default_factory=dict)
    feel: dict[str, Feel] = field(default_factory=dict)
    volts: float = 1.0
    taken: dict[str, float] = field(default_factory=dict)

    @property
    def spoils(self) -> Spoilt:
        """A copy of the present state, for the machine."""
        return dict(self.heat), dict(self.besides), dict(self.feel), self.volts, dict(self.taken)


class World:
    """A powered controller on its machine, after the first step of time, in which it starts up.

    device -- the controller; hand -- the loop's operator; wiring -- the connections that can break;
    coupling -- powers and feed of a sound machine; trips, heaters -- records of all loops; heater
    -- the record of the loop's own heater; peak_c -- highest temperature at the loop's sensor since
    `watch_peaks`, °C; peaks -- the same for all nodes.
    """

    def __init__(self, site: Site, weather: Weather, *, logs_nodes: bool = False) -> None:
        self.site = site
        self.hand = hand_of(site)
        self.wiring = Wiring()
        self.ambient_c = weather.ambient_c
        loops = site.controller.loops.values()
        sums = any(sums_noise(site.controller, loop.sensor) for loop in loops)
        period_s = site.loop.period_s  # in whole steps, otherwise readings would seem to jump
        most_s = min(STEP_S, metered_step_s(site.controller), site.controller.shortest_period_s)
        self.step_s = TICK_S if sums else period_s / math.ceil(period_s / most_s - ROUNDING)
        self.device = AvrDevice(site.controller, site.program)
        self.coupling = Coupling(site.controller, self.device, self.step_s)
        self._machine = Machine(
            self._plant(weather), self.device, self.coupling, self.step_s, logs_nodes=logs_nodes
        )
        self._spoilt = Wiring().spoils
        self._switched_on = False
        self.watch_peaks()
        self.trips = TripLog(self.device)
        self.heater = HeaterLog(self.device, {site.loop.heater})
        self.heaters = HeaterLog(self.device, {loop.heater for loop in loops})
        for log in (self.heater, self.heaters):
            self.device.record(log)
        self.trips.attach()
        self.step()

    def _plant(self, weather: Weather) -> Plant:
        self._network = network = weather.network or self.site.network
        begins_c = profile_c(
            self.site.controller, network, self.site.loop_name, weather.start_c,
            ambient_c=weather.ambient_c,
        )  # fmt: skip
        plant = plant_of(
            self.site.controller,
            network.model_copy(update={"initial_c": weather.ambient_c}),
            ambient_c=weather.ambient_c,
            step_s=self.step_s,
            seed=weather.seed,
            starts_c=begins_c,
        )
        assert isinstance(plant, Plant)  # noqa: S101 - the only kind of plant
        return plant

    # -- the machine ---------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """The controller's time, s, without the power cuts."""
        return self.device.time_s

    @property
    def sensed_c(self) -> float:
        """The machine's temperature at the loop's sensor, whatever its tip feels, °C."""
        return float(self._machine.felt[self._machine.sensors.index(self.site.loop.sensor)])

    @property
    def tip_c(self) -> float:
        """The temperature of the tip of the loop's sensor, °C."""
        feel = self.wiring.feel.get(self.site.loop.sensor)
        return feel(self.sensed_c) if feel else self.sensed_c

    def told(self, sensor: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return times, s, and a sensor's true value from each time on, in °C or A."""
        rows = self._machine.rows
        told = rows[:, BITS].astype(int) & SENSED > 0
        return rows[told, TIME], rows[told, TIPS + self._machine.sensors.index(sensor)]

    def watch_peaks(self) -> None:
        """Record the highest temperatures from now on."""
        self.peaks: Peaks = Peaks(self._machine, self.site.loop.sensor)

    @property
    def peak_c(self) -> float:
        """The highest temperature at the loop's sensor since `watch_peaks`, °C."""
        return self._machine.peak_c

    @property
    def steps(self) -> int:
        """The number of steps of time so far."""
        return self._machine.count

    def heat_s(self, first: int, last: int) -> NDArray[np.float64]:
        """Return the heat from step `first` to `last` by each loop's heater, s at full power."""
        machine, loops = self._machine, self.site.controller.loops.values()
        places = [machine.loads.index(loop.heater) for loop in loops]
        given_s: NDArray[np.float64] = machine.given(machine.rows[first:last]) * self.step_s
        heat_s: NDArray[np.float64] = given_s[:, places].sum(axis=0)
        return heat_s

    @property
    def bears_c(self) -> Mapping[str, float]:
        """Each node's highest allowed temperature, °C."""
        return bears_c(self.site.controller, self._network)

    def run(self, seconds: float) -> None:
        """Run for a time, rounded to whole steps."""
        self._go(round(seconds / self.step_s))

    def wait(self, seconds: float) -> None:
        """Run for at least a time, in whole steps, so that a key's press is long enough."""
        self._go(math.ceil(seconds / self.step_s - ROUNDING))

    def until(self, condition: Condition, within_s: float) -> bool:
        """Run until a condition holds; return False if that takes longer."""
        left, read = round(within_s / self.step_s), self.device.looked_at
        while True:
            read.clear()
            if condition(self):
                return True
            if not left:
                return False
            stop = self._stop_of(condition)
            if stop is None:
                left -= 1
                self.step()
            else:
                left = self._go(left, stop)

    def _stop_of(self, condition: Condition) -> Stop | None:
        """Return the condition as a `Stop`; None: it must be tested after each step of time."""
        if isinstance(condition, OfState):
            return Stop(changed=tuple(self.device.looked_at.values()))
        if isinstance(condition, Known):
            return condition.stop(self)
        return None

    def step(self) -> None:
        """Advance by one step of time."""
        self._go(1)

    def _go(self, steps: int, stop: Stop = NO_STOP) -> int:
        """Advance by some steps, in one go if possible. Return how many are left."""
        self._look()
        return self._machine.go(steps, stop)

    def act_within(self, act: Callable[[float], None]) -> None:
        """Advance by one step; act -- runs the device to the step's end (s) and acts within it."""
        self._look()
        self._machine.by_hand(act)

    def _look(self) -> None:
        """Tell the machine what is broken; no peaks are recorded while another source heats it."""
        wiring = self.wiring
        if wiring.spoils != self._spoilt:
            self._spoilt = heat, besides, feels, volts, taken = wiring.spoils
            self._machine.spoil(heat, besides, feels, volts=volts, taken=taken)
        self._machine.look(watches=not (self.peaks.ended or wiring.besides))

    # -- the operator --------------------------------------------------------------------------

    @contextmanager
    def at(self, loop: str) -> Iterator[None]:
        """Operate another loop within the context."""
        kept = self.site, self.hand
        self.site = replace(self.site, loop_name=loop)
        self.hand = hand_of(self.site)
        try:
            yield
        finally:
            self.site, self.hand = kept

    def do(self, action: Action) -> None:
        """Do an action of a scenario, without waiting for its effect."""
        action.give(self.device, self.coupling)

    def press(self, key: str, times: int = 1) -> None:
        """Press a key and release it, several times."""
        for _ in range(times):
            self.device.press(key)
            self.wait(PRESS_S)
            self.device.press(None)
            self.wait(PRESS_S)

    def send(self, line: str) -> None:
        """Send a line as the host, and wait for the answer."""
        self.device.send(line)
        self.until(lambda now: not now.device.host.is_busy, self._answer_s)

    def write(self, name: str, value: float | bool) -> None:
        """Write a value as the master, and wait for the answer."""
        self.device.write(name, value)
        self.until(lambda now: not now.device.master.is_busy, self._answer_s)

    @property
    def _answer_s(self) -> float:
        facts = facts_of(self.site.controller)
        slowest = min(line.baud for line in (facts.gcode, facts.modbus) if line is not None)
        return ANSWER_S + ANSWER_CHARACTERS * CHARACTER_BITS / slowest

    def acknowledge(self) -> None:
        """Acknowledge the latched fault, by key, touch or command; at the machine if locked out.

        An acknowledgement leaves a commanded loop off: it gets its setpoint again.
        """
        was_on, setpoint_c = self._switched_on, self.setpoint_c
        if self.is_locked_out:
            release(self)
        else:
            self.hand.acknowledge(self)
        if self.fault:
            return
        if was_on:
            self.switch(on=True)
        elif self.site.facts.hosted and setpoint_c:
            self.set_setpoint(setpoint_c)

    def insist(self, setpoint_c: float) -> None:
        """Acknowledge as somebody who ignores the machine, and set the setpoint, °C, again."""
        self.hand.acknowledge(self)
        if not self.fault:
            self.set_setpoint(setpoint_c)

    def switch(self, *, on: bool) -> None:
        """Switch the loop on or off; it must have a switch, not only a setpoint."""
        self._switched_on = on
        self.hand.switch(self, on=on)

    def set_setpoint(self, setpoint_c: float) -> None:
        """Set the setpoint: by command, or with UP and DOWN to the nearest step.

        A loop with a switch is switched on, too.
        """
        self.hand.set_setpoint(self, setpoint_c)
        if self.site.facts.switched:
            self.switch(on=True)

    def switch_off(self) -> None:
        """Switch the loop off, by its switch or, from a host, by a setpoint of 0."""
        if self.site.facts.switched:
            self.switch(on=False)
        else:
            self.hand.set_setpoint(self, 0.0)

    @property
    def power_on_s(self) -> float:
        """When the controller's power last came on (device time, s)."""
        return self.device.powered_s

    @property
    def setpoint_c(self) -> float:
        """The setpoint of the operator, °C."""
        return float(self.device.read(f"settings.{self.site.loop_name}_setpoint_c"))

    @property
    def screen(self) -> tuple[str, str]:
        """The display's two lines."""
        return self.device.shield.lcd.text

    def read_display(self) -> tuple[str, str]:
        """Return the two lines that a person reads on the display.

        The firmware restarts it at intervals; then its second line is dark for less than 1 ms.
        """
        if not self.screen[1].strip():
            self.step()
        return self.screen

    # -- the controller ------------------------------------------------------------------------

    @property
    def fault(self) -> int:
        """The latched fault, 0 for none."""
        return int(self.device.read("fault.code"))

    @property
    def is_locked_out(self) -> bool:
        """Whether only a person at the machine can acknowledge the latched fault (lock-out)."""
        lockout = self.site.controller.lockout
        return lockout is not None and int(self.device.read("fault.trips")) >= lockout.trips

    def loop(self, member: str) -> float:
        """Return a member of the loop's state."""
        return float(self.device.read(f"loop_{self.site.loop_name}.{member}"))

    def power_cut(self, off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
        """Cut the controller's power for a time, s, and start it. The heaters' supply stays on.

        undefined -- the value of an EEPROM byte that was being written at the cut.
        """
        self.device.feed()
        self.trips.collect()
        self.heater.power_cut()
        self.heaters.power_cut()
        if self.device.relay is not None:
            self.device.relay.power_off()
        self._look()
        for _ in range(round(off_s / self.step_s)):
            self._machine.without_power()
        self.device.power_cycle(undefined)
        self._machine.wire()
        self.trips.attach()
        self.step()
