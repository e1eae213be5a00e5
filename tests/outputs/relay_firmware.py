"""The safety relay behind the real gate, with a heater, a contact, and what can break."""

import hashlib
import random
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

from output_firmware import FLAGS, Board

from heatwright.generator import plan_firmware, render
from heatwright.sim.elf import Elf
from heatwright.sim.native.relay import Armature, Wire
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import DigitalOutput, Spec, load_text

SPEC = """
heatwright: 1
controller: {{name: relayed, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs:
  heater: {{kind: digital, pin: {heater}, active: {active}, power: 40 W}}
  contactor: {{kind: digital, pin: {relay}, active: {active}}}
loops:
  air:
    sensor: air
    heater: heater
    period: 1 s
    setpoint: {{initial: 10 °C, minimum: 0 °C, maximum: 70 °C}}
    algorithm: {{kind: on_off, hysteresis: 2 K}}
safety: {{relay: contactor{feedback}}}
interfaces: [{{kind: gcode, loops: {{T0: air}}}}]
"""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "config.h"
#include "fault.h"
#include "gate.h"
#include "output_heater.h"
#include "relay.h"

struct fault_state fault;
volatile uint8_t order_heater;
volatile uint8_t order_wanted;
volatile uint8_t order_closed; /* the gate, by order */
volatile uint8_t order_hangs;
volatile uint8_t order_acknowledged;
volatile uint8_t order_step_due;

void fault_trip(uint8_t code, float temperature_c)
{
    if (fault.code == FAULT_NONE) {
        fault.code = code;
        fault.temperature_c = temperature_c;
    }
}

int main(void)
{
#if FEEDBACK
    relay_start();
#endif
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        if (order_hangs != 0) {
            continue;
        }
        gate_renew_main();
        gate_renew_air_sensor();
        if (order_closed != 0) {
            gate_close_air();
        } else {
            gate_renew_air();
        }
        if (order_acknowledged != 0) {
            fault.code = FAULT_NONE;
        }
#if FEEDBACK
        if (order_step_due != 0) {
            relay_judge(21.0f);
        }
#endif
        output_heater_set(order_heater != 0 ? 100.0f : 0.0f);
        gate_want_air(order_wanted != 0);
    }
}
"""

BOARDS = {
    "uno": {"sensor": "A1", "heater": "D3", "relay": "D7", "feedback": "D8"},
    "mega2560": {"sensor": "D22", "heater": "D6", "relay": "D9", "feedback": "D17"},
    "atmega32": {"sensor": "PA2", "heater": "PD5", "relay": "PD6", "feedback": "PC1"},
}
"""Ports beyond the reach of `sbi` among them."""
PARTS = ("clock", "gate", "reset", "relay", "output_heater")
TICK_S = 0.01
LATE_S = 0.004
"""Into a tick: all that it did is done."""
OPERATE_S, RELEASE_S = 0.022, 0.012
"""So that the contact is, at a tick, where it was LATE_S after the one before."""
SETTLE_TICKS, CONTACT_TICKS = 5, 10
MAIN_TICKS = 10
"""The main loop's permit."""
WELDED, OPEN = 25, 26


class Orders(NamedTuple):
    """What the program does in a tick."""

    heater: bool = True
    wanted: bool = True
    closed: bool = False
    hangs: bool = False
    acknowledged: bool = False
    step_due: bool = False


class Broken(NamedTuple):
    """A line of the C, and what stands in its place."""

    file: str
    right: str
    wrong: str


def spec_of(board: str, *, feedback: bool, active: str) -> Spec:
    pins = dict(BOARDS[board])
    contact = pins.pop("feedback")
    said = f", relay_feedback: {contact}" if feedback else ""
    text = SPEC.format(board=board, active=active, feedback=said, **pins)
    return load_text(text, "spec.yaml")


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="relay-firmware-"))


def program(spec: Spec, broken: Broken | None) -> Elf:
    """Compile clock, gate, relay and heater with the program above, as strictly as a project is."""
    plan = plan_firmware(spec)
    wanted = {f"src/{name}.c" for name in PARTS}
    chosen = [each for each in plan.files if each.path in wanted or each.path.endswith(".h")]
    printed = render(replace(plan, files=tuple(chosen)))
    texts = {path.removeprefix("src/"): text for path, text in printed.items()} | {"main.c": MAIN}
    if broken:
        assert broken.right in texts[broken.file], broken
        texts[broken.file] = texts[broken.file].replace(broken.right, broken.wrong, 1)
    board = spec.controller.board
    name = hashlib.sha256(repr((board.mcu, sorted(texts.items()))).encode()).hexdigest()[:16]
    folder = _folder() / name
    elf = folder / "firmware.elf"
    if not elf.exists():
        folder.mkdir(exist_ok=True)
        for path, text in texts.items():
            (folder / path).write_text(text, encoding="utf-8")
        feedback = spec.controller.safety.relay_feedback is not None
        chip = [f"-mmcu={board.mcu}", f"-DF_CPU={board.clock_hz}UL", f"-DFEEDBACK={int(feedback)}"]
        files = [path for path in texts if path.endswith(".c")]
        lax = ["-w"] if broken else []
        command = ["avr-gcc", *chip, *FLAGS, *lax, *files, "-lm", "-o", str(elf)]
        subprocess.run(command, cwd=folder, check=True)
    return Elf(elf)


class Model:
    """What heater and relay do, from docs/safety.md."""

    def __init__(self, *, feedback: bool) -> None:
        self._feedback = feedback
        self.heater = self.relay = False
        self.fault = 0
        self._age = 0
        self._wrong = 0
        self._found = 0
        self._silent = MAIN_TICKS
        self._orders = Orders(heater=False, wanted=False, closed=True)

    def tick(self, *, says_open: bool) -> None:
        """Go on by a tick of the interrupt, by the orders before it."""
        orders = self._orders
        self._age += 1
        if self._feedback:
            self._wrong = self._wrong + 1 if says_open == self.relay else 0
            if self._wrong >= CONTACT_TICKS:
                self._found = OPEN if self.relay else WELDED
        alive = self._silent < MAIN_TICKS
        self._silent += 1
        permitted = alive and not self.fault and orders.wanted and not orders.closed
        ready = self.relay and self._age >= SETTLE_TICKS and not self._found
        self.heater = permitted and ready and orders.heater
        sure = not self._feedback or (self._age >= CONTACT_TICKS and not self._wrong)
        relay = permitted and not self._found and (self.relay or sure)
        if relay != self.relay:
            self.relay, self._age = relay, 0

    def obey(self, orders: Orders) -> None:
        """Go on by a pass of the main loop, behind the interrupt."""
        if orders.hangs:
            return
        self._silent = 0
        self._orders = orders
        if orders.acknowledged:
            self.fault = 0
        if orders.step_due and self._feedback and self._found:
            self.fault = self.fault or self._found
            self._found = 0


class RelayBoard(Board):
    """A board with a heater, a relay and perhaps its contact, run tick by tick."""

    def __init__(
        self,
        board: str = "uno",
        *,
        feedback: bool = True,
        active: str = "low",
        broken: Broken | None = None,
    ) -> None:
        spec = spec_of(board, feedback=feedback, active=active)
        super().__init__(program(spec, broken), spec.controller)
        outputs, pins = spec.controller.outputs, self.board.pins
        self.switches = {
            name: Switch(self.avr, self.board, each.pin, each.active)
            for name, each in outputs.items()
            if isinstance(each, DigitalOutput)
        }
        self.contact = pins[BOARDS[board]["feedback"]].port_name
        self.relay = self.avr.relay(
            self.switches["contactor"].pin,
            self.contact if feedback else None,
            active_high=active == "high",
            operate_s=OPERATE_S,
            release_s=RELEASE_S,
        )
        self.model = Model(feedback=feedback)
        self._feedback = feedback
        self._on = {"heater": False, "contactor": False}
        # The interrupt itself may come some cycles sooner or later.
        self._settle_cycles = round((SETTLE_TICKS * TICK_S - 1e-4) * self.board.clock_hz)
        self._closed_at = 0
        # The first tick comes 10 ms after the clock was started, some microseconds after the reset.
        self.avr.run(LATE_S)
        self.avr.pins.take()

    def fail(self, armature: Armature = Armature.SOUND, wire: Wire = Wire.SOUND) -> None:
        """Break the relay, or mend it."""
        self.relay.fail(armature, wire)

    def tick(self, orders: Orders) -> str:
        """Go on to just after the next tick; say what is not as it should be."""
        for name, value in orders._asdict().items():
            self.put(f"order_{name}", int(value))
        says_open = self._feedback and not self.avr.pins.level(self.contact)
        self.avr.run(TICK_S)
        self.model.tick(says_open=says_open)
        self.model.obey(orders)
        on = {name: switch.on for name, switch in self.switches.items()}
        seen = (on["heater"], on["contactor"], int(self.get("fault.code")))
        due = (self.model.heater, self.model.relay, self.model.fault)
        if seen != due:
            return f"heater, relay and fault are {seen}, not {due}"
        return self._judge_order()

    def _judge_order(self) -> str:
        """See in the pins' own changes that the relay switches without load."""
        events = self.avr.pins.take()
        numbers = {switch.number: name for name, switch in self.switches.items()}
        for event in events:
            name = numbers.get(int(event["pin"]))
            if name is None:
                continue
            on = bool(event["state"] & 1) == (self.switches[name].active == "high")
            cycle = int(event["cycle"])
            if name == "heater" and on and not self._on["heater"]:
                settled = cycle - self._closed_at >= self._settle_cycles
                if not self._on["contactor"] or not settled:
                    return "the heater came on before the relay had settled"
            if name == "contactor" and on != self._on["contactor"]:
                if self._on["heater"]:
                    return "the relay switched under load"
                self._closed_at = cycle
            self._on[name] = on
        return ""


def course(seed: int, ticks: int) -> Iterator[Orders]:
    """Draw orders that mostly stay as they are; a control step every tenth tick or so."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    orders = Orders()
    for _ in range(ticks):
        if drawn.random() < 0.03:
            orders = orders._replace(wanted=drawn.random() < 0.7)
        if drawn.random() < 0.05:
            orders = orders._replace(heater=drawn.random() < 0.7)
        yield orders._replace(
            closed=drawn.random() < 0.02,
            hangs=drawn.random() < 0.3,
            acknowledged=drawn.random() < 0.05,
            step_due=drawn.random() < 0.1,
        )


def breakages(seed: int) -> Iterator[tuple[Armature, Wire]]:
    """Draw what is broken from one tick to the next; mostly nothing."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    broken = Armature.SOUND, Wire.SOUND
    while True:
        if drawn.random() < 0.01:
            sound = drawn.random() < 0.6
            armature = Armature.SOUND if sound else drawn.choice(list(Armature))
            wire = Wire.SOUND if sound else drawn.choice(list(Wire))
            broken = armature, wire
        yield broken


def problem(bench: RelayBoard, orders: Iterator[Orders], seed: int | None = None) -> str:
    """Say what is wrong with a course of orders; empty if nothing."""
    broken = breakages(seed) if seed is not None else None
    for number, each in enumerate(orders):
        if broken is not None:
            bench.fail(*next(broken))
        if found := bench.tick(each):
            return f"tick {number}: {found}"
    return ""


__all__ = ["BOARDS", "Broken", "Orders", "RelayBoard", "course", "problem"]
