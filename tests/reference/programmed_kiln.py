"""A small kiln that a program drives, read in steps of 1/128 K, one step a second."""

from collections.abc import Iterable
from typing import Any

from heatwright.sim.reference import Record, Reference
from heatwright.sim.reference.numbers import Single
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


class Kiln:
    """Feeds temperatures, gives orders and collects records."""

    def __init__(self, controller: Controller | None = None) -> None:
        self.controller = controller or controller_of()
        self.reference = Reference(self.controller, "air")
        self.operator = ProgrammedOperator(self.controller, "air", self.reference)
        self.record: Record = {}

    def feed(self, temperature_c: float) -> Record:
        raw = round(temperature_c * 128)
        assert raw == temperature_c * 128, "not a temperature that the sensor can report"
        return self._step(0, raw)

    def miss(self, status: int = 1) -> Record:
        return self._step(status, 0)

    def feed_all(self, temperatures_c: Iterable[float]) -> list[Record]:
        return [self.feed(temperature_c) for temperature_c in temperatures_c]

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

    def _step(self, status: int, raw: int) -> Record:
        self.record = self.reference.step(
            status, raw, Single(self.operator.setpoint_c), orders=self.operator.orders
        )
        self.operator.after_step()
        return self.record


def begun(followed: int = 0, controller: Controller | None = None) -> Kiln:
    """Return a kiln whose program has begun at 20 °C and been followed for so many steps."""
    kiln = Kiln(controller)
    kiln.start()
    kiln.follow(followed)
    return kiln
