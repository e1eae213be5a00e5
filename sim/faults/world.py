"""A binary on its machine, with hands that can break any part of it."""

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
from heatwright.spec import ThermalNetwork, modbus_of
from heatwright.spec.board.timers import TICK_S
from heatwright.spec.commands import gcode_of, lockout_of

__all__ = [
    "STEP_S",
    "Below",
    "Condition",
    "Given",
    "Site",
    "Spread",
    "Switched",
    "Weather",
    "Wiring",
    "World",
]

STEP_S = 0.1
"""Longest time step of the machine; a tenth of the usual control period."""
ROUNDING = 1e-6
ANSWER_S = 1.0
ANSWER_CHARACTERS = 2048
CHARACTER_BITS = 11
"""Within this long, and what so many characters take, a host has had its answer, if the line works:
what it had asked before is answered first."""

Condition = Callable[["World"], bool]


@dataclass(frozen=True)
class Below:
    """The condition that the loop's sensor feels less than so many °C."""

    limit_c: float

    def __call__(self, world: World) -> bool:
        """Return whether the condition holds now."""
        return world.sensed_c < self.limit_c

    def stop(self, world: World) -> Stop:
        """Say what the machine has to wait for."""
        return Stop(below=(world.site.loop.sensor, self.limit_c))


@dataclass(frozen=True)
class Spread:
    """The condition that no node becomes hotter without heat."""

    def __call__(self, world: World) -> bool:
        """Return whether the condition holds now."""
        return not world.peaks.spreads

    def stop(self, world: World) -> Stop:
        """Say what the machine has to wait for."""
        del world
        return Stop(spread=True)


@dataclass(frozen=True)
class Given:
    """The condition that the loop's heater is given some time."""

    variable: str
    """The program's variable that holds this time."""

    def __call__(self, world: World) -> bool:
        """Return whether the condition holds now."""
        return bool(world.device.read(self.variable) > 0)

    def stop(self, world: World) -> Stop:
        """Say what the machine has to wait for."""
        return Stop(changed=(world.device.variables[self.variable],))


def given(site: Site) -> Given:
    """Return the condition that the loop's heater is given some time.

    A duty below the shortest pulse is none.
    """
    heater = site.loop.heater
    members = heater_of(site.controller, heater).members
    return Given(
        f"output_{heater}.{members[0][0]}" if members else f"loop_{site.loop_name}.duty_percent"
    )


@dataclass(frozen=True)
class Switched:
    """The condition that the pin of the loop's heater is at its active level, or is not."""

    on: bool

    def __call__(self, world: World) -> bool:
        """Return whether the condition holds now."""
        return world.device.outputs[world.site.loop.heater].on == self.on

    def stop(self, world: World) -> Stop:
        """Say what the machine has to wait for."""
        return Stop(turned=world.site.loop.heater)


@dataclass(frozen=True)
class Weather:
    """The machine at the start: what the loop's sensor feels, and the surroundings, °C.

    It has been so for long. What belongs to other loops is as cold as the surroundings.
    """

    start_c: float
    ambient_c: float
    network: ThermalNetwork | None = None
    """Another machine than the specified one."""
    seed: int = 0


Spoilt = tuple[dict[str, Heat], dict[str, Beside], dict[str, Feel], float, dict[str, float]]


@dataclass
class Wiring:
    """What lies between controller and machine, and can break.

    heat -- by output: between its pin and what it gives. besides -- by output: heat from elsewhere
    at the same place. feel -- by sensor: from the machine's temperature to the tip's, °C. volts --
    of the heaters' supply, of what it should have; taken -- by output: the share of a heater's
    power that something takes away at the same place.
    """

    heat: dict[str, Heat] = field(default_factory=dict)
    besides: dict[str, Beside] = field(default_factory=dict)
    feel: dict[str, Feel] = field(default_factory=dict)
    volts: float = 1.0
    taken: dict[str, float] = field(default_factory=dict)

    @property
    def spoils(self) -> Spoilt:
        """What of it the machine has to know, as it is now."""
        return dict(self.heat), dict(self.besides), dict(self.feel), self.volts, dict(self.taken)


class World:
    """A powered controller on its machine, after the first step of time, in which it starts.

    device -- the controller; hand -- who serves the loop; wiring -- what lies between, coupling --
    what goes to the machine when nothing is broken; trips, heaters -- what was recorded, heater --
    of the loop's own one alone; peak_c -- the highest temperature at the loop's sensor since
    `watch_peaks`, °C; peaks -- of all nodes.
    """

    def __init__(self, site: Site, weather: Weather, *, logs_nodes: bool = False) -> None:
        self.site = site
        self.hand = hand_of(site)
        self.wiring = Wiring()
        self.ambient_c = weather.ambient_c
        sensors = (loop.sensor for loop in site.controller.loops.values())
        sums = any(sums_noise(site.controller, sensor) for sensor in sensors)
        period_s = site.loop.period_s  # whole steps, or readings would seem to jump
        shortest_s = site.controller.shortest_period_s
        most_s = min(STEP_S, metered_step_s(site.controller), shortest_s)
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
        self.heaters = HeaterLog(
            self.device, {loop.heater for loop in site.controller.loops.values()}
        )
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
        assert isinstance(plant, Plant)  # noqa: S101 - the one kind there is
        return plant

    # -- the machine ---------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """The controller's time, s: power cuts do not count."""
        return self.device.time_s

    @property
    def sensed_c(self) -> float:
        """What the machine makes the loop's sensor feel, broken or not, °C."""
        return self._felt(self.site.loop.sensor)

    @property
    def tip_c(self) -> float:
        """What the tip of the loop's sensor feels, °C."""
        feel = self.wiring.feel.get(self.site.loop.sensor)
        return feel(self.sensed_c) if feel else self.sensed_c

    def tips_c(self, sensor: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return what a sensor's tip felt, °C, from each of these times on, s."""
        return self._told(sensor)

    def currents_a(self, sensor: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the current that a sensor had to see, A, from each of these times on, s."""
        return self._told(sensor)

    def _told(self, sensor: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        rows = self._machine.rows
        told = rows[:, BITS].astype(int) & SENSED > 0
        return rows[told, TIME], rows[told, TIPS + self._machine.sensors.index(sensor)]

    def watch_peaks(self) -> None:
        """Look for the highest temperatures from now on."""
        self.peaks = Peaks(self._machine, self.site.loop.sensor)

    @property
    def peak_c(self) -> float:
        """The highest temperature at the loop's sensor since `watch_peaks`, °C."""
        return self._machine.peak_c

    @property
    def bears_c(self) -> Mapping[str, float]:
        """What every node bears, °C."""
        return bears_c(self.site.controller, self._network)

    def _felt(self, sensor: str) -> float:
        return float(self._machine.felt[self._machine.sensors.index(sensor)])

    def run(self, seconds: float) -> None:
        """Run for a time, in whole steps."""
        self._go(round(seconds / self.step_s))

    def wait(self, seconds: float) -> None:
        """Run for at least a time, in whole steps: a key's press must be long enough."""
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
        """Say what the machine has to wait for; None where only a look at each step tells."""
        if isinstance(condition, OfState):
            return Stop(changed=tuple(self.device.looked_at.values()))
        if isinstance(condition, Below | Given | Spread | Switched):
            return condition.stop(self)
        return None

    def step(self) -> None:
        """Advance by one step of time."""
        self._go(1)

    def _go(self, steps: int, stop: Stop = NO_STOP) -> int:
        """Advance by some steps, together where all is sound. Return how many are left."""
        self._look()
        return self._machine.go(steps, stop)

    def act_within(self, act: Callable[[float], None]) -> None:
        """Advance by one step; act -- runs the device to its end, s, and does something in it."""
        self._look()
        self._machine.by_hand(act)

    def _look(self) -> None:
        """See what is broken now; for heat from elsewhere nothing here is to blame."""
        wiring = self.wiring
        if wiring.spoils != self._spoilt:
            self._spoilt = heat, besides, feels, volts, taken = wiring.spoils
            self._machine.spoil(heat, besides, feels, volts=volts, taken=taken)
        self._machine.look(watches=not (self.peaks.ended or wiring.besides))

    # -- the operator --------------------------------------------------------------------------

    @contextmanager
    def at(self, loop: str) -> Iterator[None]:
        """Turn to one of the loops."""
        kept = self.site, self.hand
        self.site = replace(self.site, loop_name=loop)
        self.hand = hand_of(self.site)
        try:
            yield
        finally:
            self.site, self.hand = kept

    def do(self, action: Action) -> None:
        """Do what stands in a scenario, without waiting for what follows."""
        if action.line is not None:
            self.device.send(action.line)
        elif action.write is not None:
            self.device.write(*action.write)
        elif action.program is not None:
            self.device.program(*action.program)
        elif action.extrude_mm_per_s is not None:
            self.coupling.extruded_mm_per_s = action.extrude_mm_per_s
        else:
            self.device.press(action.key)

    def press(self, key: str, times: int = 1) -> None:
        """Press a key and let it go."""
        for _ in range(times):
            self.device.press(key)
            self.wait(PRESS_S)
            self.device.press(None)
            self.wait(PRESS_S)

    def send(self, line: str) -> None:
        """Let the host send a line, and give the board time to answer."""
        self.device.send(line)
        self.until(lambda now: not now.device.host.is_busy, self._answer_s)

    def write(self, name: str, value: float | bool) -> None:
        """Let the master write a value, and give the board time to answer."""
        self.device.write(name, value)
        self.until(lambda now: not now.device.master.is_busy, self._answer_s)

    @property
    def _answer_s(self) -> float:
        lines = (gcode_of(self.site.controller), modbus_of(self.site.controller))
        slowest = min(line.baud for line in lines if line is not None)
        return ANSWER_S + ANSWER_CHARACTERS * CHARACTER_BITS / slowest

    def acknowledge(self) -> None:
        """Acknowledge the latched fault, by key, touch or command; at the machine if need be.

        A loop that is commanded is off then, and asked for the same once more.
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
        """Acknowledge without a look at the machine, and ask for a setpoint, °C, once more."""
        self.hand.acknowledge(self)
        if not self.fault:
            self.set_setpoint(setpoint_c)

    def switch(self, *, on: bool) -> None:
        """Switch a loop that is switched apart from its setpoint."""
        self._switched_on = on
        self.hand.switch(self, on=on)

    def set_setpoint(self, setpoint_c: float) -> None:
        """Ask for a setpoint: by command, or with UP and DOWN as near as the keys come.

        A loop that is switched is switched on, too.
        """
        self.hand.set_setpoint(self, setpoint_c)
        if self.site.facts.switched:
            self.switch(on=True)

    def switch_off(self) -> None:
        """Switch the loop off, by its switch or, under a host, by its setpoint."""
        if self.site.facts.switched:
            self.switch(on=False)
        else:
            self.hand.set_setpoint(self, 0.0)

    @property
    def power_on_s(self) -> float:
        """When the controller's power came on last, on its own time, s."""
        return self.device.powered_s

    @property
    def setpoint_c(self) -> float:
        """What the operator has asked for, °C."""
        return float(self.device.read(f"settings.{self.site.loop_name}_setpoint_c"))

    @property
    def screen(self) -> tuple[str, str]:
        """The display's two lines."""
        return self.device.shield.lcd.text

    def read_display(self) -> tuple[str, str]:
        """Return what somebody reads there.

        It is started anew every so often, and its second line is dark for less than a millisecond.
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
        """Whether the latched fault waits for a person at the machine."""
        lockout = lockout_of(self.site.controller)
        return lockout is not None and int(self.device.read("fault.trips")) >= lockout.trips

    def loop(self, member: str) -> float:
        """Return a number of the loop's state."""
        return float(self.device.read(f"loop_{self.site.loop_name}.{member}"))

    def power_cut(self, off_s: float = 1.0, *, undefined: int = 0xFF) -> None:
        """Cut the controller's power for a time, s, and let it start. The heater's supply stays.

        undefined -- what an EEPROM byte reads that was being written.
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
