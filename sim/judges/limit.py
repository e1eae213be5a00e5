"""The limit of a simulation's speed: what the cycles take in which its processor is awake."""

from __future__ import annotations

from time import process_time
from typing import NamedTuple

from heatwright.sim.avr import Avr
from heatwright.sim.binary.elf import Elf

ALONE_S = 10.0
"""Simulated time in which the time of a cycle is measured: 10 ms of processor time or so."""


class Limit(NamedTuple):
    """What no plant, no chip and no Python beside the processor can make faster.

    awake_per_s -- cycles awake in a simulated second; cycle_s -- processor time of one, s, with
    its share of the wakes.
    """

    awake_per_s: float
    cycle_s: float

    @property
    def speed(self) -> float:
        """How many times faster than the real machine that is."""
        return 1 / (self.awake_per_s * self.cycle_s)


def limit_of(avr: Avr, mcu: str, program: Elf) -> Limit:
    """Return the limit of a run, from its processor at the end.

    mcu, program -- run once more with nothing at the pins, to see how long a cycle takes here.
    """
    alone = Avr(mcu, avr.clock_hz)
    alone.load(program)
    start_s = process_time()
    alone.run(ALONE_S)
    took_s = process_time() - start_s
    return Limit(_awake(avr) / avr.time_s, took_s / _awake(alone))


def _awake(avr: Avr) -> int:
    return avr.cycle - avr.sleep_cycles
