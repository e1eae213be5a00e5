"""Outputs that are on or off, with minimum times, behind the real gate with its interlock."""

import hashlib
import random
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from output_firmware import FLAGS, Board

from heatwright.generator import plan_firmware, render
from heatwright.sim.elf import Elf
from heatwright.sim.outputs.switch import Switch
from heatwright.sim.reference.held import Held, held_of
from heatwright.spec import Controller, DigitalOutput, load_text

SPEC = """
heatwright: 1
controller: {{name: held, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs:
  heater: {{kind: {kind}, pin: {heater}, power: 40 W{heater_more}}}
  cooler: {{kind: digital, pin: {cooler}{cooler_more}}}
loops:
  air:
    sensor: air
    heater: heater
    cooler: cooler
    period: 1 s
    setpoint: {{initial: 10 °C, minimum: 0 °C, maximum: 70 °C}}
    algorithm: {{kind: three_position, dead_band: 2 K}}
"""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "config.h"
#include "fault.h"
#include "gate.h"
#include "output_cooler.h"
#include "output_heater.h"
#include "reset.h"

struct fault_state fault;
volatile uint8_t heater_asked; /* % */
volatile uint8_t cooler_asked;
volatile uint8_t latched;
volatile uint8_t stop;
volatile uint8_t told;

void fault_trip(uint8_t code, float temperature_c)
{
    fault.code = code;
    fault.temperature_c = temperature_c;
}

int main(void)
{
#if STARTS
    output_heater_start();
#endif
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        gate_renew_main();
        gate_renew_air();
        gate_renew_air_sensor();
        fault.code = latched;
        output_heater_set((float)heater_asked);
        output_cooler_set(cooler_asked != 0 ? 100.0f : 0.0f);
#if STOPS
        if (stop != 0) {
            output_heater_stop();
        }
#endif
        told = (uint8_t)(output_heater_is_on() | (output_cooler_is_on() << 1));
    }
}
"""

BOARDS = {
    "uno": {"sensor": "A1", "heater": "D3", "cooler": "D7"},
    "mega2560": {"sensor": "D22", "heater": "D6", "cooler": "D9"},
    "atmega32": {"sensor": "PA2", "heater": "PD5", "cooler": "PD6"},
}
"""A port beyond the reach of `sbi` among them."""
KINDS = {
    "pwm": ("pwm", ", frequency: 976.5625 Hz"),
    "pwm by interrupts": ("pwm", ", frequency: 100 Hz"),
    "windows": ("time_proportional", ", window: 1 s"),
}
"""Other heaters than a digital one."""
PARTS = ("clock", "gate", "reset", "output_heater", "output_cooler")
TICK_S = 0.01
LATE_S = 0.004
"""Into a tick: all that it did is done."""


class Orders(NamedTuple):
    """What the program asks for in a tick."""

    heater: bool
    cooler: bool
    latched: bool = False
    stop: bool = False


class Broken(NamedTuple):
    """A line of an output's C, and what stands in its place."""

    file: str
    right: str
    wrong: str


def controller_of(board: str, heater_more: str = "", cooler_more: str = "") -> Controller:
    return load_text(_text(board, heater_more, cooler_more), "spec.yaml").controller


def _text(board: str, heater_more: str, cooler_more: str) -> str:
    kind, heater_more = KINDS.get(heater_more, ("digital", heater_more))
    pins = BOARDS[board]
    return SPEC.format(
        board=board, kind=kind, heater_more=heater_more, cooler_more=cooler_more, **pins
    )


@cache
def _folder() -> Path:
    return Path(tempfile.mkdtemp(prefix="held-firmware-"))


def sources(board: str, heater_more: str, cooler_more: str) -> dict[str, str]:
    """Print clock, gate, both outputs and all headers."""
    plan = plan_firmware(load_text(_text(board, heater_more, cooler_more), "spec.yaml"))
    wanted = {f"src/{name}.c" for name in PARTS}
    chosen = [each for each in plan.files if each.path in wanted or each.path.endswith(".h")]
    files = render(replace(plan, files=tuple(chosen)))
    return {path.removeprefix("src/"): text for path, text in files.items()}


def program(board: str, heater_more: str, cooler_more: str, broken: Broken | None) -> Elf:
    texts = sources(board, heater_more, cooler_more) | {"main.c": MAIN}
    if broken:
        assert texts[broken.file].count(broken.right) >= 1, broken
        texts[broken.file] = texts[broken.file].replace(broken.right, broken.wrong, 1)
    name = hashlib.sha256(repr((board, sorted(texts.items()))).encode()).hexdigest()[:16]
    folder = _folder() / name
    elf = folder / "firmware.elf"
    if not elf.exists():
        folder.mkdir(exist_ok=True)
        for path, text in texts.items():
            (folder / path).write_text(text, encoding="utf-8")
        made = controller_of(board, heater_more, cooler_more).board
        chip = [f"-mmcu={made.mcu}", f"-DF_CPU={made.clock_hz}UL"]
        header = texts["output_heater.h"]
        chip += [f"-DSTOPS={int('_stop(' in header)}", f"-DSTARTS={int('_start(' in header)}"]
        files = [path for path in texts if path.endswith(".c")]
        command = ["avr-gcc", *chip, *FLAGS, *(["-w"] * bool(broken)), *files, "-lm", "-o", elf]
        subprocess.run(command, cwd=folder, check=True)
    return Elf(elf)


class HeldBoard(Board):
    """A board with a heater and a cooler, run tick by tick, beside the reference of both."""

    def __init__(
        self,
        board: str = "uno",
        heater_more: str = "",
        cooler_more: str = "",
        broken: Broken | None = None,
    ) -> None:
        self.controller = controller_of(board, heater_more, cooler_more)
        self.program = program(board, heater_more, cooler_more, broken)
        super().__init__(self.program, self.controller)
        self.stops = "output_heater_stop" in self.program.symbols
        made: Mapping[str, Any] = self.controller.outputs
        self.switches = {
            name: Switch(self.avr, self.board, each.pin, each.active) for name, each in made.items()
        }
        self.models: dict[str, Held] = {
            name: held_of(each) if isinstance(each, DigitalOutput) else Held(0, 0)
            for name, each in made.items()
        }
        self._orders = Orders(heater=False, cooler=False)
        self._started = False
        self.percent = 100
        self._last = dict.fromkeys(self.switches, False)
        # The first tick comes 10 ms after the clock was started, some microseconds after the reset.
        self.avr.run(LATE_S)

    def tick(self, orders: Orders) -> tuple[tuple[bool, bool], tuple[bool, bool]]:
        """Go on to just after the next tick; return what is on, and what should be.

        The tick's interrupt switches by the orders before; then the program takes these.
        """
        self.put("heater_asked", self.percent * orders.heater)
        self.put("cooler_asked", orders.cooler)
        self.put("latched", orders.latched)
        self.put("stop", orders.stop)
        self.avr.run(TICK_S)
        heater, cooler = self.models["heater"], self.models["cooler"]
        heater.tick(permitted=not self._orders.latched and self._started and not cooler.on)
        cooler.tick(permitted=not heater.on)
        heater.set(asked=orders.heater)
        cooler.set(asked=orders.cooler)
        if orders.stop and self.stops:
            heater.stop()
        self._orders, self._started = orders, True
        return self.seen(), (heater.on, cooler.on)

    def seen(self) -> tuple[bool, bool]:
        return self.switches["heater"].on, self.switches["cooler"].on

    def overlap(self) -> int:
        """Return how often both were on at once, by the pins' own changes, since the last call."""
        events = self.avr.pins.take()
        on = self._last
        numbers = {switch.number: name for name, switch in self.switches.items()}
        both = 0
        for pin, level in zip(events["pin"].tolist(), events["state"].tolist(), strict=True):
            name = numbers[pin]
            on[name] = bool(level & 1) == (self.switches[name].active == "high")
            both += all(on.values())
        return both

    def told(self) -> tuple[bool, bool]:
        """Return what the outputs say of themselves."""
        told = int(self.get("told"))
        return bool(told & 1), bool(told & 2)


def course(seed: int, ticks: int) -> list[Orders]:
    """Draw orders that mostly stay as they are, and sometimes contradict each other."""
    drawn = random.Random(seed)  # noqa: S311 - no secret
    orders = Orders(heater=False, cooler=False)
    found = []
    for _ in range(ticks):
        if drawn.random() < 0.2:
            orders = orders._replace(heater=drawn.random() < 0.5)
        if drawn.random() < 0.2:
            orders = orders._replace(cooler=drawn.random() < 0.5)
        orders = orders._replace(latched=drawn.random() < 0.03, stop=drawn.random() < 0.03)
        found.append(orders)
    return found


def problem(bench: HeldBoard, orders: list[Orders]) -> str:
    """Say what is wrong with a course of orders; empty if nothing."""
    for number, each in enumerate(orders):
        seen, due = bench.tick(each)
        if seen != due:
            return f"tick {number}: heater and cooler are {seen}, not {due}"
        if bench.told() != due:
            return f"tick {number}: it is said that they are {bench.told()}"
    if bench.overlap():
        return "both on at once"
    return ""


__all__ = ["BOARDS", "Broken", "HeldBoard", "Orders", "course", "problem"]
