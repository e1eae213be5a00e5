"""A feed by itself: the generated stepper, told by the test what loops and host would tell it."""

import numpy as np
from numpy.typing import NDArray
from output_firmware import Board, Broken, controller_of, program

from heatwright.sim.outputs.stepper import attach
from heatwright.spec import Stepper

MAIN = """
#include "output_feed.h"

struct fault_state fault;
volatile uint8_t healthy = 1;
volatile uint8_t ready = 1;
volatile int32_t steps;
volatile float speed;
volatile uint8_t stop;
volatile uint8_t disable;
volatile uint16_t deaf_us;
volatile int32_t position;
volatile uint8_t busy;

bool loop_air_is_ready(void) { return ready != 0; }

void gate_tick(void)
{
    if (!healthy) {
        output_feed_halt();
    }
}

static void obey(void)
{
    if (stop != 0) {
        stop = 0;
        output_feed_stop();
    }
    if (disable != 0) {
        disable = 0;
        output_feed_disable();
    }
    if (steps != 0) {
        output_feed_move(steps, speed);
        steps = 0;
    }
}

int main(void)
{
    pin_output_feed_enable_off(); /* as reset.c does */
    pin_output_feed_enable_drive();
    output_feed_start();
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        obey();
        output_feed_tick();
        position = output_feed_position();
        busy = output_feed_is_busy();
        cli();
        for (uint16_t left = deaf_us; left != 0; left--) {
            __builtin_avr_delay_cycles(9); /* and the loop's own: 1 us at 16 MHz */
        }
        sei();
    }
}
"""


class Feed(Board):
    """The feed on a board, its driver and motor simulated."""

    def __init__(self, board: str, settings: str, broken: Broken | None = None) -> None:
        outputs = {"feed": f"kind: stepper, {settings}"}
        controller = controller_of(board, outputs)
        self.program = program(board, outputs, MAIN, broken=broken)
        super().__init__(self.program, controller)
        output = controller.outputs["feed"]
        assert isinstance(output, Stepper)
        self.output = output
        self.driver = attach(self.avr, controller.board, output)
        self.run(0.1)

    def move(self, steps: int, mm_per_s: float) -> None:
        """Give an order, which the next tick takes."""
        self.put("speed", mm_per_s)
        self.put("steps", steps)
        self.run(0.02)

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.avr.run(seconds)
        self.driver.feed(self.avr.pins.take(), np.zeros(0))

    def finish(self, most_s: float) -> None:
        """Run until it is at rest."""
        start = self.avr.time_s
        while self.get("busy"):
            assert self.avr.time_s < start + most_s
            self.run(0.05)

    @property
    def times_s(self) -> NDArray[np.float64]:
        """When each step came."""
        times: NDArray[np.float64] = self.driver.steps["cycle"] / self.avr.clock_hz
        return times
