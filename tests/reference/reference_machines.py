"""Machines of the reference model: fed with temperatures and orders, they keep their records."""

import dataclasses
from collections.abc import Iterable
from typing import Any

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.inputs import AUTOMATIC, MANUAL, TUNING, Gains, Limits, Orders
from heatwright.sim.reference.interfaces.modbus_rtu import Master
from heatwright.sim.reference.interfaces.nextion import Display
from heatwright.sim.reference.interfaces.switched import SwitchedOperator
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.programs.copies import copy_of
from heatwright.sim.reference.programs.orders import ProgrammedOperator
from heatwright.sim.reference.programs.state import RESTORING
from heatwright.spec import Controller, PwmOutput, load_text


class Player:
    """A loop of a model that keeps its last record; its sensor has so many steps in a kelvin."""

    steps_per_k = 16

    def __init__(self, controller: Controller, loop: str = "air", setpoint_c: float = 50.0) -> None:
        self.controller = controller
        self.reference = Reference(controller, loop)
        self.setpoint_c = setpoint_c
        self.record: Record = {}

    def anew(self) -> None:
        type(self).__init__(self, self.controller)

    def feed(self, temperature_c: float, status: int = 0, **said: Any) -> Record:
        raw = round(temperature_c * self.steps_per_k)
        assert raw == temperature_c * self.steps_per_k, "no temperature that the sensor can report"
        return self.step(status, 0 if status else raw, **said)

    def miss(self, status: int = 1) -> Record:
        return self.step(status, 0)

    def feed_all(self, temperatures_c: Iterable[float]) -> list[Record]:
        return [self.feed(temperature_c) for temperature_c in temperatures_c]

    def saw(self, centre_c: float, count: int) -> list[Record]:
        """Feed a reading that moves by one sensor step, so that it is not frozen."""
        return self.feed_all(centre_c + number % 2 / 16 for number in range(count))

    def ramp(self, first_c: float, last_c: float, by_k: float) -> list[Record]:
        count = round((last_c - first_c) / by_k) + 1
        return self.feed_all(first_c + n * by_k for n in range(count))

    def step(self, status: int, raw: int, **said: Any) -> Record:
        self.record = self.reference.step(status, raw, Single(self.setpoint_c), **said)
        return self.record


KILN = """
heatwright: 1
controller: {name: box, board: mega2560}
sensors:
  air: {kind: max31856, chip_select: D49, clock: D52, data_in: D51, data_out: D50, AVERAGE}
outputs:
  heater: {kind: time_proportional, pin: D2, window: 1 s, power: 1 kW}
loops:
  air:
    {sensor: air, heater: heater, period: PERIOD, algorithm: {kind: pid, kp: 1, ALGORITHM},
     setpoint: {initial: 20 °C, minimum: 0 °C, maximum: 1000 °C},
     protection: {maximum: 1100 °C, rise_rate: RISE, heating: off, frozen: FROZEN,
                  rising_while_off: off, runaway: RUNAWAY, PROTECTION}}
programs:
  loop: air
  PROGRAMS
  stored:
    - {name: first, segments: [SEGMENTS]}
    - {name: second, segments: [{hold: until operator}]}
interfaces: [{kind: nextion, loop: air}]
"""
RAMP_AND_HOLD = "{to: 40 °C, over: 20 s}, {hold: 5 s}, {to: 30 °C, over: 5 s}"
DEFAULTS = {
    "AVERAGE": "average: 1", "PERIOD": "1 s", "ALGORITHM": "kd: 0", "RISE": "2000 K/s",
    "FROZEN": "off", "RUNAWAY": "{above: 25 K, for: 3 s}", "PROTECTION": "stale_after: 5 s",
    "PROGRAMS": "hold_back: {within: 10 K, limit: 5 s}",
}  # fmt: skip


def kiln_of(segments: str = RAMP_AND_HOLD, **parts: str) -> Controller:
    """A spec with these parts in the place of its words in capitals; a semicolon ends a key."""
    text = KILN.replace("SEGMENTS", segments)
    for word, default in DEFAULTS.items():
        text = text.replace(word, parts.get(word.lower(), default).replace("; ", "\n  "))
    return load_text(text, "box.yaml").controller


class Kiln(Player):
    steps_per_k = 128

    def __init__(self, controller: Controller | None = None) -> None:
        super().__init__(controller or kiln_of())
        self.operator = ProgrammedOperator(self.controller, "air", self.reference)

    def follow(self, steps: int, above_k: float = 0.0) -> list[Record]:
        """Read what the setpoint is, so far above it, as near as the sensor can say it."""
        return [
            self.feed(round((float(self.record["setpoint_c"]) + above_k) * 128) / 128)
            for _ in range(steps)
        ]

    def order(self, order: str, number: int = 0) -> bool:
        return self.operator.order(order, number)

    def said(self, *words: str) -> None:
        Display(self.controller, self.operator, self.operator.acknowledge).send(" ".join(words))

    def start(self, number: int = 1, temperature_c: float = 20.0) -> Record:
        assert self.order("start", number)
        return self.feed(temperature_c)

    def begun(self, followed: int) -> None:
        self.start()
        self.follow(followed)

    def cut(self, state: int = RESTORING) -> None:
        """Lose power at 35 °C on the way up, and go on by what a record of the run tells."""
        self.anew()
        self.begun(15)
        before_c = Single(self.record["setpoint_c"])
        last = self.reference.program.now
        now = dataclasses.replace(last, state=state, before_c=before_c, leap=0)
        self.anew()
        self.reference.program.load(1, copy_of(self.controller.programs.stored[0]))
        self.reference.program.restore(now)

    def step(self, status: int, raw: int, **said: Any) -> Record:
        self.setpoint_c = float(self.operator.setpoint_c)
        record = super().step(status, raw, orders=self.operator.orders, **said)
        self.operator.after_step()
        return record


COMMANDED = """
heatwright: 1
controller: {name: box, board: uno}
sensors:
  air: {kind: ds18b20, pin: A1}
outputs:
  heater: {kind: pwm, pin: D3, frequency: 490 Hz, power: 240 W}
loops:
  air:
    {sensor: air, heater: heater, period: 1 s, LOOP,
     algorithm: {kind: pid, kp: 2, ki: 0.5, kd: 8, ALGORITHM},
     setpoint: {initial: 0 °C, minimum: 0 °C, maximum: 100 °C},
     protection: {maximum: 120 °C, PROTECTION}}
interfaces: [{kind: gcode, loops: {T0: air}}]
"""


def commanded_of(
    algorithm: str = "derivative_filter: 0 s",
    loop: str = "autotune: {}",
    protection: str = "frozen: off",
) -> Controller:
    text = COMMANDED.replace("ALGORITHM", algorithm).replace("LOOP", loop)
    return load_text(text.replace("PROTECTION", protection), "box.yaml").controller


class Commanded(Player):
    def __init__(self, controller: Controller, setpoint_c: float = 50.0) -> None:
        super().__init__(controller, setpoint_c=setpoint_c)
        self.mode = AUTOMATIC
        self.manual_percent = 0.0
        self.set_gains(2, 0.5, 8)
        self.limits: Limits | None = None
        self.master_lost = False

    @property
    def tuner(self) -> Any:
        return self.reference.steering.tuner

    def set_gains(self, kp: float, ki: float, kd: float) -> None:
        self.gains: Gains | None = Gains(Single(kp), Single(ki), Single(kd))

    def set_limits(self, least: float, most: float, full: float) -> None:
        self.limits = Limits(Single(least), Single(most), Single(full))

    def by_hand(self, percent: float) -> None:
        self.mode, self.manual_percent = MANUAL, percent

    def tune(self, target_c: float, cycles: int | None = None) -> None:
        self.setpoint_c, self.mode = target_c, TUNING
        self.tuner.start(cycles)

    def swing(self) -> list[Record]:
        """Once up at one slope and down at another."""
        return self.ramp(75, 83, 2) + self.ramp(85, 74, -1)

    def step(self, status: int, raw: int, **said: Any) -> Record:
        orders = Orders(self.mode, Single(self.manual_percent), self.gains, self.limits)
        orders = orders._replace(master_lost=self.master_lost)
        return super().step(status, raw, orders=orders, **said)


NOZZLE = """
heatwright: 1
controller: {name: box, board: mega2560}
sensors:
  nozzle: {kind: ds18b20, pin: A2}
  current: {kind: current, pin: A1, scale: 0.2 V/A, oversample: 4}
outputs:
  heater: {kind: pwm, pin: D5, frequency: 1 kHz, power: 100 W, supply: 50 V, current: CURRENT}
  cooler: {kind: digital, pin: D22}
loops:
  nozzle:
    {sensor: nozzle, heater: heater, cooler: cooler, period: 1 s, starts: disabled,
     setpoint: {initial: 50 °C, minimum: 0 °C, maximum: 100 °C},
     algorithm: {kind: three_position, dead_band: 2 K},
     protection: {maximum: 120 °C, minimum: -5 °C, rise_rate: 100 K/s, heating: off, runaway: off,
                  frozen: off, rising_while_off: off, master_lost_after: 5 s}}
interfaces: [{kind: modbus_rtu}]
"""
LIMIT = "{sensor: current, limit: 2.5 A}"


def nozzle_of(current: str = LIMIT) -> Controller:
    return load_text(NOZZLE.replace("CURRENT", current), "box.yaml").controller


STEP_A = 5 / 1024 / 0.2


class Nozzle(Player):
    def __init__(self, controller: Controller | None = None) -> None:
        super().__init__(controller or nozzle_of(), "nozzle")
        self.operator = SwitchedOperator(self.controller, "nozzle", self.reference)
        operators = {"nozzle": self.operator}
        self.write = Master(self.controller, operators, self.operator.acknowledge).write
        self.operated = False
        """Whether its operator and master command it, and not `enabled` and the setpoint."""
        self.enabled = 1
        self.ohm = 25.0
        """Resistance of the heater at 50 V; what it draws follows from the last duty."""
        heater = self.controller.outputs["heater"]
        assert isinstance(heater, PwmOutput)
        self.full = ((heater.rated_v or 50.0) / 50.0) ** 2
        """Share of the time that it is on at full duty."""
        self.amperes: float | None = None

    def step(self, status: int, raw: int, **said: Any) -> Record:
        share = float(self.reference.duty_percent) / 100 * self.full
        amperes = 50.0 / self.ohm * share if self.amperes is None else self.amperes
        raw_current = round(4 * (amperes / STEP_A - 0.5))  # the middle of a code, four times
        wanted = Orders(enabled=self.enabled, current_raw=max(0, raw_current), **said)
        if self.operated:
            self.setpoint_c = float(self.operator.setpoint_c)
            wanted = wanted._replace(enabled=self.operator.orders.enabled)
        record = super().step(status, raw, orders=wanted)
        self.operator.after_step()
        return record
