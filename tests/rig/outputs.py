"""The generated outputs on a board, with a program of the test's around them. Gate, relay and reset
are the real ones, or the gate is the test's (`permitted`); clock and outputs are always real. The
program does what the test asks for by its variables, once a tick."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rig.firmware import Board, Program, sources_of, spec_of

from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.outputs.switch import Switch
from heatwright.spec import Controller, Stepper

Outputs = Mapping[str, str]
"""What the file says of each output, by its name. `heater` is the loop's, and so is `cooler`;
`contactor` is the safety relay; the host commands the others."""

SPEC = """
heatwright: 1
controller: {{name: outputs, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs:
  {outputs}
loops:
  air:
    sensor: air
    heater: heater
    {control}
    period: 1 s
    setpoint: {{initial: 0 °C, minimum: 0 °C, maximum: 70 °C}}
    {ready}
safety: {{{safety}}}
interfaces: [{interface}]
"""
PID = "algorithm: {kind: pid, kp: 10, ki: 0.1}"
ON_OFF = "algorithm: {kind: on_off, hysteresis: 2 K}"
COOLED = "algorithm: {kind: three_position, dead_band: 2 K}\n    cooler: cooler"
PINS = {
    "uno": ("A1", "D2"), "nano": ("A1", "D2"), "leonardo": ("A1", "D2"),
    "mega2560": ("A1", "D22"), "atmega328p": ("PC1", "PD2"), "atmega2560": ("PF1", "PA0"),
    **dict.fromkeys(("atmega644p", "atmega1284p", "atmega32", "atmega16"), ("PA1", "PA2")),
}  # fmt: skip
"""A sensor's and a heater's, of no interest to the test."""

MAIN = """
#include <avr/interrupt.h>
#include <avr/wdt.h>
#include "clock.h"
#include "config.h"
#include "fault.h"
#include "gate.h"
#include "loop_air.h"
#include "pins.h"
#include "reset.h"
{includes}

struct fault_state fault;
uint8_t fault_complement = UINT8_MAX;
volatile uint8_t permitted = 1; /* by the gate of the test's */
volatile uint8_t hangs;
volatile uint8_t gate_closed; /* the real one, by order */
volatile uint8_t relay_wanted;
volatile uint8_t relay_judged;
volatile uint8_t restart; /* 1: at address 0; 2: by the watchdog */
volatile uint8_t ready = 1;
volatile uint16_t deaf_us;
{variables}

void fault_trip(uint8_t code, float temperature_c)
{{
    if (fault.code == FAULT_NONE) {{
        fault.code = code;
        fault.temperature_c = temperature_c;
    }}
}}

bool loop_air_is_ready(void) {{ return ready != 0; }}
{gate}

static void obey(void)
{{
{orders}
}}

static __attribute__((noinline)) void start_again(void) {{ __asm__ volatile("jmp 0"); }}

int main(void)
{{
    reset_report();
{starts}
    clock_start();
    sei();
    for (;;) {{
        clock_wait();
        if (hangs != 0) {{
            continue;
        }}
        obey();
        cli();
        for (uint16_t left = deaf_us; left != 0; left--) {{
            __builtin_avr_delay_cycles(9); /* and the loop's own: 1 us at 16 MHz */
        }}
        if (restart == 2) {{
            wdt_enable(WDTO_15MS);
            for (;;) {{
            }}
        }}
        if (restart != 0) {{
            restart = 0;
            start_again();
        }}
        sei();
    }}
}}
"""
GATE = """
void gate_tick(void)
{{
{ticks}
}}
"""
RENEW = """
    gate_renew_main();
    gate_renew_air();
    gate_renew_air_sensor();"""
CLOSE = """
    if (gate_closed != 0) {
        gate_close_air();
    }"""
WANT = "\n    gate_want_air(relay_wanted != 0);"
JUDGE = """
    if (relay_judged != 0) {
        relay_judge(21.0f);
    }"""

DOES = {
    "set": ("volatile float {0}_percent;\nvolatile uint8_t {0}_set;", """
    if ({0}_set != 0) {{
        {0}_set = 0;
        output_{0}_set({0}_percent);
    }}"""),
    **{does: (f"volatile uint8_t {{0}}_{does};", f"""
    if ({{0}}_{does} != 0) {{{{
        {{0}}_{does} = 0;
        output_{{0}}_{does}();
    }}}}""") for does in ("stop", "disable")},
    "move": ("volatile int32_t {0}_steps;\nvolatile float {0}_speed;", """
    if ({0}_steps != 0) {{
        output_{0}_move({0}_steps, {0}_speed);
        {0}_steps = 0;
    }}
    output_{0}_tick();"""),
    "is_on": ("volatile uint8_t {0}_told;", "\n    {0}_told = output_{0}_is_on();"),
    "position": ("volatile int32_t {0}_position;", "\n    {0}_position = output_{0}_position();"),
    "is_busy": ("volatile uint8_t {0}_busy;", "\n    {0}_busy = output_{0}_is_busy();"),
}  # fmt: skip
"""What the program does with an output that has such a function: its variables, and each tick."""
STEPPER_START = """
    pin_output_{0}_enable_off(); /* as reset.c does */
    pin_output_{0}_enable_drive();"""


@dataclass(frozen=True)
class Wired:
    """Outputs, the board they are on, and which gate is before them."""

    board: str
    outputs: tuple[tuple[str, str], ...]
    gate: bool = False  # the real one; else the test's, which only `permitted` closes
    feedback: str = ""  # the pin of the safety relay's contact, if it has one

    @cached_property
    def text(self) -> str:
        sensor, pin = PINS[self.board]
        said = dict(self.outputs)
        heater = f"kind: time_proportional, window: 1 s, pin: {pin}, power: 40 W"
        others = [name for name in said if name not in {"heater", "cooler", "contactor"}]
        steppers = [name for name in others if "stepper" in said[name]]
        fans = [name for name in others if name not in steppers]
        listed = ", ".join(f"P{number}: {name}" for number, name in enumerate(fans))
        fed = ", ".join(f"E: {name}" for name in steppers)
        hosted = f"{{kind: gcode, loops: {{T0: air}}, fans: {{{listed}}}, steppers: {{{fed}}}}}"
        relay = "relay: contactor" if "contactor" in said else ""
        digital = "kind: digital" in said.get("heater", "")
        cooled, all_said = "cooler" in said, {"heater": heater} | said
        return SPEC.format(
            board=self.board, sensor=sensor, ready="" if cooled else "ready_within: 3 K",
            outputs="\n  ".join(f"{name}: {{{each}}}" for name, each in all_said.items()),
            control=COOLED if cooled else ON_OFF if digital else PID,
            safety=f"{relay}, relay_feedback: {self.feedback}" if self.feedback else relay,
            interface="" if cooled else hosted,
        )  # fmt: skip

    @property
    def controller(self) -> Controller:
        return spec_of(self.text).controller

    @cached_property
    def program(self) -> Program:
        """Say what is compiled: clock, reset, outputs, and gate and relay if they are real."""
        there = sources_of(self.text)
        names = [f"output_{name}" for name in dict(self.outputs) if f"output_{name}.c" in there]
        if self.gate:
            names += ["output_heater", "gate"]
            names += ["relay"] if "contactor" in dict(self.outputs) else []
        return Program(self.text, ("clock", "reset", *dict.fromkeys(names)), self._main())

    def _main(self) -> str:
        """Write the main program: what it can do with each output, its header says."""
        headers = sources_of(self.text)
        includes, variables, orders, starts, ticks = "", "", "", "", ""
        if self.gate:
            orders = RENEW
            orders += CLOSE * ("gate_close_air(" in headers["gate.h"])
            orders += JUDGE * ("relay_judge(" in headers.get("relay.h", ""))
            starts = "    relay_start();\n" * ("relay_start(" in headers.get("relay.h", ""))
            includes = '#include "relay.h"\n' * ("relay.h" in headers)
        for name, said in self.outputs:
            header = headers.get(f"output_{name}.h", "")
            includes += f'#include "output_{name}.h"\n' * bool(header)
            for does, (variable, order) in DOES.items():
                if f"output_{name}_{does}(" in header:
                    variables += variable.format(name) + "\n"
                    orders += order.format(name)
            if "kind: stepper" in said:
                starts += STEPPER_START.format(name)
                ticks += f"    if (!permitted) {{\n        output_{name}_halt();\n    }}\n"
            if f"output_{name}_start(" in header:
                starts += f"    output_{name}_start();\n"
        if "heater" in dict(self.outputs):
            ticks += "    output_heater_tick(permitted != 0);\n"
        orders += WANT * (self.gate and "gate_want_air(" in headers["gate.h"])
        gate = "" if self.gate else GATE.format(ticks=ticks)
        return MAIN.format(
            includes=includes, variables=variables, orders=orders, starts=starts, gate=gate
        )


def wired(board: str, outputs: Outputs, *, gate: bool = False, feedback: str = "") -> Wired:
    return Wired(board, tuple(outputs.items()), gate, feedback)


TICK_S = 0.01
LATE_S = 0.004  # into a tick: all that it did is done


class Change(NamedTuple):
    cycle: int
    name: str
    on: bool


def changes(events: NDArray[Any], outputs: Mapping[str, Switch]) -> Iterator[Change]:
    numbers = {switch.number: name for name, switch in outputs.items()}
    for event in events[np.isin(events["pin"], list(numbers))]:
        name = numbers[int(event["pin"])]
        on = bool(event["state"] & 1) == (outputs[name].active == "high")
        yield Change(int(event["cycle"]), name, on)


class OutputBoard(Board):
    def __init__(self, place: Wired, elf: Elf | None = None) -> None:
        self.controller = place.controller
        super().__init__(elf or place.program.elf(), self.controller.board)
        self.outputs = {
            name: Switch(self.avr, self.board, output.pin, output.active)
            for name, output in self.controller.outputs.items()
            if name in dict(place.outputs) and not isinstance(output, Stepper)
        }
        for switch in self.outputs.values():
            switch.log_edges()

    def ask(self, name: str, percent: float) -> None:
        """Ask for a share: the program takes it in the next tick, behind the interrupt."""
        self.put(f"{name}_percent", percent)
        self.put(f"{name}_set", 1)

    def changes(self) -> Iterator[Change]:
        return changes(self.avr.pins.take(), self.outputs)


class Recorded:
    """What some outputs of a whole firmware did: a recorder of the device."""

    def __init__(self, device: AvrDevice, *names: str) -> None:
        self.found: list[Change] = []
        self._on = dict.fromkeys(names, False)
        self._switches = {name: device.outputs[name] for name in names}
        device.log_edges(names)
        device.record(self)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        del sent
        for change in changes(pins, self._switches):
            if change.on != self._on[change.name]:
                self._on[change.name] = change.on
                self.found.append(change)

    def cycles(self, name: str) -> list[int]:
        return [change.cycle for change in self.found if change.name == name]


FIRST = 40  # cycles from the reset vector to the pin, some ten instructions on


def reset_problem(bench: OutputBoard, name: str) -> str:
    """Reset it: the output is off before anything else, and never on again by itself."""
    switch = bench.outputs[name]
    bench.avr.reset()
    bench.avr.pins.take()
    reset_at = bench.avr.cycle
    bench.avr.run(0.2)
    if switch.on or not switch.driven:
        return "on, or not driven, after a reset"
    # The board's resistor first, then the program, and never the load.
    mine = [change for change in bench.changes() if change.name == name]
    if mine[-1].cycle - reset_at > FIRST:
        return f"off only {mine[-1].cycle - reset_at} cycles after the reset"
    return "on for a moment after a reset" if any(change.on for change in mine) else ""


WATCHDOG_RESET, BROWN_OUT = 14, 15  # faults
MCUSR, POWER_ON, BROWNED_OUT = 0x54, 1, 4
HANG_MARK = 0x5AC3
TIMER_0 = {False: (0x45, 0x6E), True: (0x53, 0x59)}
"""Where its clock and its interrupts' mask stand, TCCR0B and TIMSK0; on old chips TCCR0, TIMSK."""


def cause_problem(place: Wired, elf: Elf | None = None) -> str:
    """Reset it in every way: what is tripped, and that it is not reset again."""
    bench = OutputBoard(place, elf)
    bench.avr.write_ram(MCUSR, bytes([POWER_ON | BROWNED_OUT]))  # as at a normal power-up
    marked = "reset_power_mark" in bench
    if marked:
        bench.put("reset_power_mark", 1)  # of a lock-out, which only a loss of power ends
    bench.avr.run(0.1)
    if bench.get("fault.code"):
        return "a power-up trips"
    if marked and bench.get("reset_power_mark"):
        return "a power-up keeps the mark of a lock-out"
    for number, (cause, due) in enumerate(
        (("brown_out", BROWN_OUT), ("external", 0), ("watchdog", WATCHDOG_RESET), ("external", 0))
    ):
        bench.put("restart", 2 * (cause == "watchdog"))
        if cause != "watchdog":
            bench.avr.reset(cause)  # type: ignore[arg-type]
        bench.avr.run(0.5)
        if len(bench.avr.take_resets()) != 1:
            return f"reset {number}: not one"
        if (bench.get("fault.code"), bench.get("fault.temperature_c")) != (due, 0.0):
            return f"reset {number} by {cause}: fault {bench.get('fault.code')}, not {due}"
    if not place.gate:
        return ""
    return _hang_problem(OutputBoard(place, elf)) or _unasked_problem(OutputBoard(place, elf))


def _unasked_problem(bench: OutputBoard) -> str:
    """An interrupt nobody has asked for, of timer 0: the watchdog resets soon, the mark tells."""
    for ends_by in ("watchdog", "external"):
        bench.avr.run(0.3)
        bench.avr.take_resets()
        for register in TIMER_0[bench.board.is_old]:
            bench.avr.flip(register, 0)
        bench.avr.run(0.002)
        if ends_by == "external":
            bench.avr.reset("external")
        bench.avr.run(0.05)
        if len(bench.avr.take_resets()) != 1:
            return f"an interrupt that nobody asked for: not one reset, by {ends_by}"
        if bench.get("fault.code") != WATCHDOG_RESET:
            return f"an interrupt that nobody asked for: fault {bench.get('fault.code')}"
        bench.put("fault.code", 0)
    return ""


def _hang_problem(bench: OutputBoard) -> str:
    """A boot loader may hide the watchdog: then a mark tells of the hang, once."""
    bench.avr.run(0.1)
    for hangs, due in ((0, 0), (1, WATCHDOG_RESET), (0, 0)):
        bench.put("hangs", hangs)
        bench.avr.run(0.2)
        found = _fault_after_reset(bench, 0.005)  # the main loop has not run yet
        if found != due:
            return f"behind a hang: fault {found}, not {due}"
        if _fault_after_reset(bench, 0.05):
            return "a hang is told twice"
    for random in (HANG_MARK - 1, HANG_MARK + 1):
        bench.put("reset_hang_mark", random)
        if _fault_after_reset(bench, 0.005):
            return "what memory has by chance is taken for a hang"
    return ""


def _fault_after_reset(bench: OutputBoard, seconds: float) -> int:
    bench.avr.reset("external")
    bench.avr.run(seconds)
    return int(bench.get("fault.code"))
