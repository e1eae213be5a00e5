"""PWM outputs by themselves: a program that gives them what shares the test asks for."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from output_firmware import Board, Broken, Outputs, controller_of, program

from heatwright.sim.outputs.switch import Switch
from heatwright.spec.pwm_timers import PwmChannel
from heatwright.spec.timers import allocate

MAIN = """
{includes}
#include <avr/wdt.h>

struct fault_state fault;
volatile uint8_t permitted = 1;
volatile uint8_t restart;
volatile uint16_t deaf_us;
{variables}

void fault_trip(uint8_t code, float temperature_c)
{{
    fault.code = code;
    fault.temperature_c = temperature_c;
}}

void gate_tick(void)
{{
{ticks}
}}

static void obey(void)
{{
{orders}
}}

static __attribute__((noinline)) void start_again(void)
{{
    __asm__ volatile("jmp 0");
}}

int main(void)
{{
{starts}
    clock_start();
    sei();
    for (;;) {{
        clock_wait();
        obey();
        cli();
        for (uint16_t left = deaf_us; left != 0; left--) {{
            __builtin_avr_delay_cycles(9); /* and the loop's own: 1 us at 16 MHz */
        }}
        if (restart != 0) {{
            restart = 0;
            start_again();
        }}
        sei();
    }}
}}
"""


def main_of(outputs: Outputs) -> str:
    """Write the program."""
    names = list(outputs)
    every = {
        "includes": '#include "output_{0}.h"\n',
        "variables": "volatile float {0}_percent;\nvolatile uint8_t {0}_set;\n",
        "starts": "    output_{0}_start();\n",
        "orders": "    if ({0}_set != 0) {{\n        {0}_set = 0;\n"
        "        output_{0}_set({0}_percent);\n    }}\n",
    }
    parts = {key: "".join(text.format(name) for name in names) for key, text in every.items()}
    gated = "    output_heater_tick(permitted != 0);\n" if "heater" in names else ""
    return MAIN.format(**parts, ticks=gated)


class Pulses(NamedTuple):
    """What was seen of an output, in cycles of the processor."""

    periods: NDArray[np.int64]
    """From one beginning to the next."""
    widths: NDArray[np.int64]
    """Of whole pulses."""
    share: float
    """Of the time that it was on."""


class PwmBoard(Board):
    """A board with these outputs, each a switch on its pin."""

    def __init__(
        self, board: str, outputs: Outputs, *others: str, broken: Broken | None = None
    ) -> None:
        self.controller = controller_of(board, outputs)
        self.program = program(board, outputs, main_of(outputs), *others, broken=broken)
        super().__init__(self.program, self.controller)
        self.channels: dict[str, PwmChannel] = dict(allocate(self.controller).pwm)
        self.outputs = {
            name: Switch(self.avr, self.board, output.pin, output.active)
            for name, output in self.controller.outputs.items()
            if name in outputs and output.kind == "pwm"
        }
        self.avr.run(0.05)

    def ask(self, name: str, percent: float) -> None:
        """Ask for a share, and wait until it is there."""
        self.put(f"{name}_percent", percent)
        self.put(f"{name}_set", 1)
        self.avr.run(0.03 + 2 / self.channels[name].frequency_hz)

    def seen(self, name: str, seconds: float) -> Pulses:
        """Run on and look at an output."""
        switch = self.outputs[name]
        switch.on_fraction()
        self.avr.pins.take()
        self.avr.run(seconds)
        share = switch.on_fraction()
        events = self.avr.pins.take()
        mine = events[events["pin"] == switch.number]
        on = (mine["state"] & 1 == 1) == (switch.active == "high")
        cycles = mine["cycle"].astype(np.int64)
        begins, ends = cycles[on], cycles[~on]
        begins_whole = begins[begins < ends[-1]] if len(ends) else begins[:0]
        widths = ends[np.searchsorted(ends, begins_whole)] - begins_whole
        return Pulses(np.diff(begins), widths, share)

    def cycles_of(self, name: str) -> int:
        """Cycles of a period, as the allocation says."""
        return self.channels[name].prescaler * self.channels[name].counts
