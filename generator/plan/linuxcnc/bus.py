"""The line, as mb2hal's configuration has it: format, how often it is used, how long to wait."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, log10

from heatwright.generator.plan.linuxcnc.names import controller_name
from heatwright.generator.plan.linuxcnc.transactions import Transaction, transactions
from heatwright.generator.plan.modbus.silence import silence_s
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, ModbusRtu

ANSWER_S = 0.005
"""Within this time after the silence the slave answers."""
MARGIN_S = 1.0
"""For a PC without real time and a USB adapter that keeps bytes. Ample, for an answer that comes
later is taken for that to the next request: RTU frames have no numbers."""
FASTEST_HZ = 5.0
"""More does not show on a panel."""
MOST_LOAD = 0.5
"""Share of the time for which the line may be busy."""
MOST_SILENCE = 0.25
"""Share of the time after which the master counts as lost that may pass between two rounds."""
HEARD_WITHIN_S = 5.0
"""The exchange counts as lost after so long, if the spec does not say when a master is lost."""


@dataclass(frozen=True, slots=True)
class BusTransaction:
    """A section of mb2hal's configuration."""

    section: str
    name: str
    first: int
    function: str
    pins: str
    where: str


@dataclass(frozen=True, slots=True)
class BusNames:
    """All that mb2hal's configuration needs to know."""

    name: str
    where: str
    port: str
    address: int
    baud: int
    parity: str
    stop_bits: int
    delay_ms: int
    timeout_ms: int
    round: str
    rate: str
    transactions: list[BusTransaction]


def bus_names(source: Source, interface: ModbusRtu) -> BusNames:
    """Find what mb2hal's configuration needs to know."""
    round_ = transactions(source)
    return BusNames(
        name=controller_name(source.controller),
        where=source.where,
        port=port_name(source),
        address=interface.address,
        baud=interface.baud,
        parity=interface.parity,
        stop_bits=interface.stop_bits,
        delay_ms=ceil(1000 * silence_s(interface)),
        timeout_ms=ceil(1000 * answer_within_s(interface)),
        round=f"{round_s(interface, round_):.2g} s",
        rate=f"{rate_hz(source, interface):.2g}",
        transactions=[
            BusTransaction(
                section=f"TRANSACTION_{number:02d}",
                name=each.name,
                first=each.first,
                function=each.function,
                pins=",".join(each.pins),
                where=each.where,
            )
            for number, each in enumerate(round_)
        ],
    )


def port_name(source: Source) -> str:
    """Name of the link to the serial port that the user makes beside the configuration."""
    return f"{source.controller.identity.name}_port"


def round_s(interface: ModbusRtu, round_: tuple[Transaction, ...]) -> float:
    """How long all transactions take, one after the other, s."""
    line_s = sum(each.line_bytes for each in round_) * _character_s(interface)
    return line_s + len(round_) * (2 * silence_s(interface) + ANSWER_S)


def rate_hz(source: Source, interface: ModbusRtu) -> float:
    """How often a round is made, rounded down: as often as the line bears it.

    On a slow line that may be so seldom that the master would count as lost: then more often.
    """
    busy_s = round_s(interface, transactions(source))
    seldom_hz = 1 / (busy_s + MOST_SILENCE * lost_after_s(source.controller))
    hertz = min(FASTEST_HZ, max(MOST_LOAD / busy_s, seldom_hz))
    step = 10.0 ** (floor(log10(hertz)) - 1)
    return floor(hertz / step) * step


def lost_after_s(controller: Controller) -> float:
    """After so long without a request one of the loops counts its master as lost, s."""
    times = [loop.protection.master_lost_after_s for loop in controller.loops.values()]
    return min((time for time in times if time is not None), default=HEARD_WITHIN_S)


def _character_s(interface: ModbusRtu) -> float:
    return interface.character_bits / interface.baud


def answer_within_s(interface: ModbusRtu) -> float:
    """From the end of mb2hal's writing to the first byte of an answer; the line has to send all."""
    longest_request = 8 * _character_s(interface)
    return longest_request + silence_s(interface) + ANSWER_S + MARGIN_S
