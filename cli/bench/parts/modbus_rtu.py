"""A master on the Modbus line, which reads and writes all registers."""

import struct
from collections.abc import Iterator
from typing import Any

from heatwright.cli.bench.parts.seat import BadOrder, Live, Order, Seat, text_of
from heatwright.cli.bench.recorded import event_of, with_unit
from heatwright.cli.bench.world import LiveWorld
from heatwright.sim.interfaces.modbus_rtu import frames
from heatwright.sim.interfaces.modbus_rtu.frames import Exchange
from heatwright.sim.interfaces.modbus_rtu.registers import Register, registers
from heatwright.spec import Controller
from heatwright.spec.scenario.writes import AMOUNTS, GAINS

FUNCTIONS = {"coil": 1, "discrete_input": 2, "holding_register": 3, "input_register": 4}
WRITABLE = ("coil", "holding_register")


class Master(Seat):
    """A person at a Modbus master."""

    kind = "modbus_rtu"

    def __init__(self, controller: Controller, number: int) -> None:
        super().__init__(controller, number)
        self._registers = registers(controller)
        self._asked: list[tuple[Exchange, list[Register]]] = []
        self._values: dict[str, float] = {}

    def about(self) -> dict[str, Any]:
        """Return the list of all registers."""
        return {
            "registers": [
                {
                    "name": each.name,
                    "table": each.table,
                    "address": each.address,
                    "kind": each.kind,
                    "unit": _unit(each.name),
                    "writable": each.table in WRITABLE,
                }
                for each in self._registers.values()
            ]
        }

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return the known values, and the request that was refused last."""
        master = self.part(world)
        self._asked = [each for each in self._asked if not self._took(*each)]
        self._values |= master.values
        del master.refusals[:-1]
        refused = [
            {
                "time_s": world.device.powered_s + each.time_s,
                "name": each.name,
                "code": each.exception,
            }
            for each in master.refusals
        ]
        return {"values": dict(self._values), "refused": refused, "asking": bool(self._asked)}

    def act(self, live: Live, order: Order) -> None:
        """Write a value, or read all tables."""
        if order.get("read"):
            master = self.part(live.world)
            self._asked += [(master.ask(pdu), found) for pdu, found in self._reads()]
            return
        name = text_of(order, "name", 80)
        if name not in self._registers or self._registers[name].table not in WRITABLE:
            raise BadOrder(f"The slave has no register {name} that can be written.")
        what = {"write": {name: with_unit(name, order.get("value"))}}
        for write in event_of(what).write or ():
            try:
                self._registers[write.name].raw(write.value)
            except (struct.error, OverflowError):
                raise BadOrder(f"{write.name}: the value is out of its register's range.") from None
            live.world.device.write(*write)
        live.record(what)

    def _took(self, exchange: Exchange, found: list[Register]) -> bool:
        """Read the values of an answer, if it has come; return whether the exchange is over."""
        if exchange.answer is None or exchange.refusal:
            return exchange.done
        first = found[0].address
        if found[0].kind == "bit":
            bits = exchange.answer.bits()
            self._values |= {each.name: float(bits[each.address - first]) for each in found}
        else:
            words = exchange.answer.words()
            for each in found:
                at = each.address - first
                self._values[each.name] = each.value(words[at : at + each.words])
        return True

    def _reads(self) -> Iterator[tuple[bytes, list[Register]]]:
        """Yield requests for all tables but the one that the master polls by itself."""
        for table, function in FUNCTIONS.items():
            blocks: dict[int, list[Register]] = {}
            for each in self._registers.values():
                if each.table == table != "input_register":
                    blocks.setdefault(each.address // 100, []).append(each)
            for found in blocks.values():
                ends = max(each.address + each.words for each in found)
                yield frames.read(function, found[0].address, ends - found[0].address), found


def _unit(name: str) -> str:
    """Return the unit in which a register is written, or ""."""
    what = name.rpartition(".")[2]
    return AMOUNTS[what].base if what in AMOUNTS else GAINS.get(what, "")


take = Master
