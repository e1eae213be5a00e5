"""Readings of each loop of a Modbus slave, from its input registers."""

from collections.abc import Iterator

from heatwright.cli.plot.hearing import Cut, Hearing, Read, Reading
from heatwright.generator.plan.registers import NO_TEMPERATURE
from heatwright.sim.interfaces.modbus_rtu.frames import answer_to, framed, read
from heatwright.sim.interfaces.modbus_rtu.registers import Register, registers
from heatwright.spec import Controller, ModbusRtu

ASKED = ("temperature", "duty", "setpoint_in_force")
"""These registers are adjacent in each loop's block: one request reads them."""
INPUT_REGISTERS = 4
EVERY_S = 1.0


def hearings(controller: Controller, interface: ModbusRtu) -> Iterator[Hearing]:
    """Yield the request for each loop's registers, and the way to read its answer."""
    known = registers(controller)
    for loop in controller.loops:
        asked = [known[f"{loop}.{name}"] for name in ASKED]
        pdu = read(INPUT_REGISTERS, asked[0].address, len(asked))
        asks = framed(interface.address, pdu)
        cut = _cut(interface.address, pdu, len(asked))
        yield Hearing(loop, interface.kind, interface.line, _read(asked), asks, EVERY_S, cut)


def _cut(address: int, pdu: bytes, words: int) -> Cut:
    """Find the answers in the received bytes, and return them as hexadecimal numbers.

    Damaged answers, and those of other slaves, are skipped byte by byte.
    """
    size = len(framed(address, bytes(2 + 2 * words)))

    def cut(come: bytes) -> tuple[list[str], bytes]:
        found, at = [], 0
        while len(come) - at >= size:
            frame = come[at : at + size]
            if answer_to(address, pdu, frame) is None:
                at += 1
            else:
                found.append(frame.hex(" "))
                at += size
        return found, come[at:]

    return cut


def _read(asked: list[Register]) -> Read:
    def read_words(text: str, time_s: float) -> Iterator[Reading]:
        data = bytes.fromhex(text)[3:-2]  # behind address, function and size; before the checksum
        words = [int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data), 2)]
        if len(words) != len(asked):
            return
        temperature_c, duty_percent, setpoint_c = (
            register.value([word]) for register, word in zip(asked, words, strict=True)
        )
        none = temperature_c == asked[0].scale * NO_TEMPERATURE
        yield Reading(time_s, None if none else temperature_c, setpoint_c, duty_percent)

    return read_words
