"""The stack told from the code is the stack that the program takes when the worst comes together.

The program waits at its deepest place for its deepest interrupt, so the two must be equal.
"""

import pytest
from rig.avr import compiled, powered

from heatwright.generator.stack import worst_stack

PROGRAM = """
volatile uint8_t fired, sink;
volatile float mean = 1;

__attribute__((noinline, noclone)) void fill(uint8_t n)
{
    volatile uint8_t frame[30];
    for (uint8_t i = 0; i < 30; i++)
        frame[i] = n + i;
    sink = frame[n % 30];
}

__attribute__((noinline, noclone)) void wait(uint16_t n)
{
    volatile uint8_t frame[300];
    frame[n] = 1;
    fired = 0;
    while (!fired)
        ;
    sink = frame[n / 2];
}

__attribute__((noinline, noclone)) uint8_t choose(uint8_t n)
{
    switch (n) {
    case 0: return PINB;
    case 1: return PINC;
    case 2: return 9;
    case 3: sink = 4; return 7;
    case 4: wait(n); return 3;
    case 5: sink = 1; return 3;
    case 6: mean = mean / 3 + 1; return 3;
    case 7: sink = 2; return 1;
    }
    return 0;
}

ISR(TIMER1_OVF_vect) { fill(sink); fired = 1; }
ISR(TIMER0_OVF_vect) { sink++; }

int main(void)
{
    TCCR1B = 1 << CS10;
#ifdef TIMSK1
    TIMSK1 = 1 << TOIE1;
#endif
#ifdef TIMSK0
    TCCR0B = 1 << CS00;
    TIMSK0 = 1 << TOIE0;
#else
    TCCR0 = 1 << CS00;
    TIMSK = 1 << TOIE0 | 1 << TOIE1;
#endif
    sei();
    for (uint8_t n = 0;; n++)
        sink += choose(n % 8);
}
"""


@pytest.mark.parametrize("flags", ["-Os", "-Os -flto", "-O2", "-O1 -mcall-prologues", "-O0"])
@pytest.mark.parametrize("mcu", ["atmega328p", "atmega2560", "atmega1284p", "atmega32"])
def test_the_bound_is_reached(mcu: str, flags: str) -> None:
    program = compiled(PROGRAM, *flags.split(), mcu=mcu)
    avr = powered(program, mcu)
    profile = avr.profile(program)
    avr.run(0.05)
    assert profile.stack_used == worst_stack(program.path).total
