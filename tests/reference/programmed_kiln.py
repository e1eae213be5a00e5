"""A small kiln that a program drives, read in steps of 1/128 K, one step a second."""

import dataclasses
from typing import Any

from player import Player

from heatwright.sim.reference import Record
from heatwright.sim.reference.copies import copy_of
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.program_state import RESTORING
from heatwright.sim.reference.programmed import ProgrammedOperator
from heatwright.spec import Controller, load_text

TEXT = """
heatwright: 1
controller: {name: box, board: mega2560}
sensors:
  air: {kind: max31856, chip_select: D49, clock: D52, data_in: D51, data_out: D50, AVERAGE}
outputs:
  heater: {kind: time_proportional, pin: D2, window: 1 s, power: 1 kW}
loops:
  air:
    sensor: air
    heater: heater
    period: PERIOD
    setpoint: {initial: 20 °C, minimum: 0 °C, maximum: 1000 °C}
    algorithm: {kind: pid, kp: 1, ALGORITHM}
    protection:
      maximum: 1100 °C
      rise_rate: RISE
      heating: off
      frozen: FROZEN
      rising_while_off: off
      runaway: RUNAWAY
      PROTECTION
programs:
  loop: air
  PROGRAMS
  stored:
    - name: first
      segments: [SEGMENTS]
    - name: second
      segments: [{hold: until operator}]
interfaces:
  - {kind: nextion, loop: air}
"""
RAMP_AND_HOLD = "{to: 40 °C, over: 20 s}, {hold: 5 s}, {to: 30 °C, over: 5 s}"


DEFAULTS = {
    "AVERAGE": "average: 1",
    "PERIOD": "1 s",
    "ALGORITHM": "kd: 0",
    "RISE": "2000 K/s",
    "FROZEN": "off",
    "RUNAWAY": "{above: 25 K, for: 3 s}",
    "PROTECTION": "stale_after: 5 s",
    "PROGRAMS": "hold_back: {within: 10 K, limit: 5 s}",
}


def controller_of(segments: str = RAMP_AND_HOLD, **parts: str) -> Controller:
    """A spec with these parts in the place of its words in capitals."""
    text = TEXT.replace("SEGMENTS", segments)
    for word, default in DEFAULTS.items():
        text = text.replace(word, parts.get(word.lower(), default))
    return load_text(text, "box.yaml").controller


class Kiln(Player):
    """Feeds temperatures, gives orders and collects records."""

    steps_per_k = 128

    def __init__(self, controller: Controller | None = None) -> None:
        self.controller = controller or controller_of()
        super().__init__(self.controller)
        self.operator = ProgrammedOperator(self.controller, "air", self.reference)

    def follow(self, steps: int, above_k: float = 0.0) -> list[Record]:
        """Read what the setpoint is, so far above it, as near as the sensor can say it."""
        found = []
        for _ in range(steps):
            wanted_c = float(self.record["setpoint_c"]) + above_k
            found.append(self.feed(round(wanted_c * 128) / 128))
        return found

    def order(self, order: str, number: int = 0) -> bool:
        return self.operator.order(order, number)

    def start(self, number: int = 1, temperature_c: float = 20.0) -> Record:
        assert self.order("start", number)
        return self.feed(temperature_c)

    def of_program(self, *names: str) -> tuple[Any, ...]:
        return tuple(self.record[f"program.{name}"] for name in names)

    def lose_power(self, state: int = RESTORING) -> None:
        """Begin anew with what a record of the run tells; the kiln was where it should be."""
        before_c = Single(self.record["setpoint_c"])
        now = dataclasses.replace(
            self.reference.program.now, state=state, before_c=before_c, leap=0
        )
        self.__init__(self.controller)
        self.reference.program.load(1, copy_of(self.controller.programs.stored[0]))
        self.reference.program.restore(now)

    def step(self, status: int, raw: int, **said: Any) -> Record:
        self.setpoint_c = float(self.operator.setpoint_c)
        record = super().step(status, raw, orders=self.operator.orders, **said)
        self.operator.after_step()
        return record
