"""The line in mb2hal's configuration: format, rate of the transactions, time-out of answers."""

from dataclasses import dataclass
from math import ceil, floor, log10

from heatwright.generator.plan.linuxcnc.names import controller_name
from heatwright.generator.plan.linuxcnc.transactions import Transaction, transactions
from heatwright.generator.plan.modbus.silence import silence_s
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, ModbusRtu

ANSWER_S = 0.005
"""Longest time from the silence after a request to the slave's answer."""
MARGIN_S = 1.0
"""Margin for a PC without real time and a USB adapter that buffers. It is ample, because a late
answer is taken for the next request's: RTU frames have no numbers."""
FASTEST_HZ = 5.0
"""Highest rate of the rounds: a higher one is not visible on a panel."""
MOST_LOAD = 0.5
"""Largest share of the time for which the line may be busy."""
MOST_SILENCE = 0.25
"""Longest time between two rounds, as a share of the time after which the master is lost."""
HEARD_WITHIN_S = 5.0
"""Time after which the connection is lost, if the spec has no time for a lost master."""


@dataclass(frozen=True, slots=True)
class BusNames:
    """The values for mb2hal's configuration."""

    name: str
    where: str
    port: str
    interface: ModbusRtu
    delay_ms: int
    timeout_ms: int
    round: str
    rate: str
    transactions: tuple[Transaction, ...]


def bus_names(source: Source, interface: ModbusRtu) -> BusNames:
    """Compute the values for mb2hal's configuration."""
    round_ = transactions(source)
    return BusNames(
        name=controller_name(source.controller),
        where=source.where,
        port=port_name(source),
        interface=interface,
        delay_ms=ceil(1000 * silence_s(interface)),
        timeout_ms=ceil(1000 * answer_within_s(interface)),
        round=f"{round_s(interface, round_):.2g} s",
        rate=f"{rate_hz(source, interface):.2g}",
        transactions=round_,
    )


def port_name(source: Source) -> str:
    """Name of the link to the serial port that the user creates beside the configuration."""
    return f"{source.controller.identity.name}_port"


def round_s(interface: ModbusRtu, round_: tuple[Transaction, ...]) -> float:
    """Time for all transactions, one after the other, s."""
    line_s = sum(each.line_bytes for each in round_) * _character_s(interface)
    return line_s + len(round_) * (2 * silence_s(interface) + ANSWER_S)


def rate_hz(source: Source, interface: ModbusRtu) -> float:
    """Return the rate of the rounds, rounded down: FASTEST_HZ, or what MOST_LOAD allows if less.

    If the master would be lost at this rate, it is higher.
    """
    busy_s = round_s(interface, transactions(source))
    seldom_hz = 1 / (busy_s + MOST_SILENCE * lost_after_s(source.controller))
    hertz = min(FASTEST_HZ, max(MOST_LOAD / busy_s, seldom_hz))
    step = 10.0 ** (floor(log10(hertz)) - 1)
    return floor(hertz / step) * step


def lost_after_s(controller: Controller) -> float:
    """Shortest time without a request after which the master of a loop is lost, s."""
    times = [loop.protection.master_lost_after_s for loop in controller.loops.values()]
    return min((time for time in times if time is not None), default=HEARD_WITHIN_S)


def _character_s(interface: ModbusRtu) -> float:
    return interface.character_bits / interface.baud


def answer_within_s(interface: ModbusRtu) -> float:
    """Longest time from the end of mb2hal's write call to an answer's first byte, s."""
    longest_request = 8 * _character_s(interface)
    return longest_request + silence_s(interface) + ANSWER_S + MARGIN_S
