"""The limit of a simulation's speed: the computing time of its processor's awake cycles."""

from time import process_time
from typing import NamedTuple

from heatwright.sim.avr import Avr
from heatwright.sim.binary.elf import Elf

ALONE_S = 10.0
"""Simulated time for measuring the computing time of a cycle: about 10 ms of processor time."""


class Limit(NamedTuple):
    """The limit that plant, chips and Python cannot improve.

    awake_per_s -- awake cycles per simulated second; cycle_s -- computing time of an awake cycle,
    s, with its share of the wake-ups.
    """

    awake_per_s: float
    cycle_s: float

    @property
    def speed(self) -> float:
        """The highest speed, as a multiple of real time."""
        return 1 / (self.awake_per_s * self.cycle_s)


def limit_of(avr: Avr, mcu: str, program: Elf) -> Limit:
    """Return the limit of a run, from its processor at the end.

    mcu, program -- run again with nothing at the pins, to measure a cycle on this computer.
    """
    alone = Avr(mcu, avr.clock_hz)
    alone.load(program)
    start_s = process_time()
    alone.run(ALONE_S)
    took_s = process_time() - start_s
    return Limit(_awake(avr) / avr.time_s, took_s / _awake(alone))


def _awake(avr: Avr) -> int:
    return avr.cycle - avr.sleep_cycles
