"""The worst stack of small programs whose depth is counted by hand, and what is refused.

`+` in a comment is one byte on the stack; C is the size of a return address, two bytes on most
chips and three on an ATmega2560. `main` is called from the start-up code: C.
"""

import subprocess
from pathlib import Path

import pytest
from rig.avr import compiled

from heatwright.generator.stack import StackUnknown, WorstStack, worst_stack

LOOP = "int main(void) { for (;;); }\n"
C = {"atmega328p": 2, "atmega2560": 3, "atmega16": 2}


def measure(source: str, mcu: str = "atmega328p", *flags: str) -> WorstStack:
    return worst_stack(compiled(source, "-lm", *flags, mcu=mcu).path)


@pytest.mark.parametrize("mcu", C)
def test_main_alone_takes_the_call_to_it(mcu: str) -> None:
    stack = measure(LOOP, mcu)
    assert stack == WorstStack(C[mcu], 0, ("reset", "main"), ())


@pytest.mark.parametrize("mcu", C)
def test_calls_and_pushes_add_up_along_the_deepest_chain(mcu: str) -> None:
    source = r"""
    __attribute__((naked, used)) void leaf(void) { asm("push r2\n pop r2\n ret"); }
    __attribute__((naked, used)) void deep(void)
    { asm("push r2\n push r3\n push r4\n call leaf\n pop r4\n pop r3\n pop r2\n ret"); }
    int main(void) { for (;;) { asm("call leaf"); asm("call deep"); } }
    """
    stack = measure(source, mcu)
    assert stack.program == 3 * C[mcu] + 3 + 1  # main, deep, leaf
    assert stack.program_chain == ("reset", "main", "deep", "leaf")


@pytest.mark.parametrize(("room", "kept"), [(1, 2), (5, 2), (40, 2), (100, 2), (700, 2)])
@pytest.mark.parametrize("mcu", C)
def test_room_for_variables_counts(mcu: str, room: int, kept: int) -> None:
    # The compiler makes room by `push`, `rcall .+0`, `sbiw` or `subi` and `sbci`, by its size.
    source = f"""
    __attribute__((noinline)) void fill(uint16_t i)
    {{ volatile uint8_t frame[{room}]; frame[i] = 1; frame[i / 2] = frame[i]; }}
    int main(void) {{ for (;;) fill(PINB); }}
    """
    assert measure(source, mcu).program == 2 * C[mcu] + kept + room  # main, fill: Y and the frame


def test_arguments_on_the_stack_count() -> None:
    source = r"""
    __attribute__((noinline, noclone)) uint8_t sum(uint8_t n, ...) { asm volatile(""); return n; }
    int main(void) { for (;;) PORTB = sum(3, 1L, 2L); }
    """
    # main's call, then n and two longs, then the call of sum; sum keeps Y to find them.
    assert measure(source).program == 2 + 1 + 4 + 4 + 2 + 2


@pytest.mark.parametrize("mcu", C)
def test_the_deepest_interrupt_comes_on_top(mcu: str) -> None:
    source = r"""
    ISR(TIMER0_OVF_vect, ISR_NAKED) { asm("push r2\n pop r2\n reti"); }
    ISR(TIMER1_OVF_vect, ISR_NAKED) { asm("push r2\n push r3\n pop r3\n pop r2\n reti"); }
    """
    stack = measure(source + LOOP, mcu)
    assert (stack.program, stack.interrupts) == (C[mcu], C[mcu] + 2)
    assert stack.total == 2 * C[mcu] + 2


def test_an_interrupt_that_lets_others_in_adds_to_them() -> None:
    source = r"""
    ISR(TIMER0_OVF_vect, ISR_NAKED) { asm("sei\n push r2\n pop r2\n reti"); }
    ISR(TIMER1_OVF_vect, ISR_NAKED) { asm("push r2\n push r3\n pop r3\n pop r2\n reti"); }
    ISR(TIMER2_OVF_vect, ISR_NAKED) { asm("push r2\n pop r2\n reti"); }
    """
    assert measure(source + LOOP).interrupts == (2 + 1) + (2 + 2)


SWITCH = """
__attribute__((noinline)) uint8_t leaf(uint8_t n) { volatile uint8_t b[20]; b[n] = n; return *b; }
__attribute__((noinline)) uint8_t choose(uint8_t n)
{
    switch (n) {
    case 0: return PINB;
    case 1: return PINC;
    case 2: return 9;
    case 3: PORTC = 4; return 7;
    case 4: return PIND;
    case 5: PORTB = 1; return 3;
    case 6: return leaf(n) + 3;
    case 7: PORTD = 2; return 1;
    }
    return 0;
}
int main(void) { for (;;) PORTB = choose(PINB); }
"""


@pytest.mark.parametrize("mcu", C)
def test_a_switch_by_table_is_followed_into_every_case(mcu: str) -> None:
    stack = measure(SWITCH, mcu)
    assert stack.program_chain == ("reset", "main", "choose", "leaf")
    assert stack.program == 3 * C[mcu] + 2 + 20


TABLE_IN_THE_CODE = """
    .macro function name
    .global \\name
    .type \\name, @function
    .size \\name, .Lend_\\name - \\name
    \\name:
    .endm
    jmp main
function main
    call choose
    rjmp main
.Lend_main:
function leaf
    push r2
    pop r2
    ret
.Lend_leaf:
function __tablejump2__
    lsl r30
    rol r31
    lpm r0, Z+
    lpm r31, Z
    mov r30, r0
    ijmp
.Lend___tablejump2__:
    .org 0x3b64
function choose
    push r28
    push r29
    in r28, 0x3d
    in r29, 0x3e
    sbiw r28, 20
    out 0x3e, r29
    out 0x3d, r28
    mov r30, r24
    ldi r31, 0
    subi r30, lo8(-(gs(.Ltable)))
    sbci r31, hi8(-(gs(.Ltable)))
    jmp __tablejump2__
.Ltable:
    .word gs(.Lone), gs(.Lother)
.Lone:
    nop
    rjmp .Lout
.Lother:
    call leaf
.Lout:
    adiw r28, 20
    out 0x3e, r29
    out 0x3d, r28
    pop r29
    pop r28
    ret
.Lend_choose:
"""


def test_a_table_between_a_switch_and_its_cases_is_read(tmp_path: Path) -> None:
    """gcc 7 puts it there. Its words, 0x1dcx, would be `adc r28, rx` as instructions."""
    (tmp_path / "main.S").write_text(TABLE_IN_THE_CODE)
    command = "avr-gcc -mmcu=atmega328p -nostdlib -Wl,--defsym=__stack=0x8ff -o main.elf main.S"
    subprocess.run(command.split(), cwd=tmp_path, check=True)
    stack = worst_stack(tmp_path / "main.elf")
    assert stack.program_chain == ("reset", "choose", "leaf")
    assert stack.program == 2 + 2 + 20 + 2 + 1


@pytest.mark.parametrize("mcu", C)
def test_shared_prologues_are_followed(mcu: str) -> None:
    source = """
    __attribute__((noinline)) void fill(uint16_t i)
    {
        volatile uint8_t frame[40];
        asm volatile("" ::: "r8", "r9", "r10", "r11", "r12", "r13", "r14", "r15", "r16", "r17");
        frame[i] = frame[i / 2];
    }
    int main(void) { for (;;) fill(PINB); }
    """
    assert measure(source, mcu, "-mcall-prologues").program == 2 * C[mcu] + 10 + 2 + 40


def test_library_routines_are_followed() -> None:
    stack = measure("int main(void) { volatile float x = 2; for (;;) x = x / 3 + x; }\n")
    assert stack.program_chain[:2] == ("reset", "main")
    assert any(name.startswith(("__divsf3", "__addsf3")) for name in stack.program_chain)


REFUSED = {
    "recursion": (
        "__attribute__((noinline)) uint8_t f(uint8_t n) { PORTB = n; if (n) f(1); return PINC; }\n"
        "int main(void) { for (;;) PORTB = f(9); }\n",
        "f calls itself: main → f → f",
    ),
    "mutual recursion": (
        "uint8_t g(uint8_t n);\n"
        "__attribute__((noinline)) uint8_t f(uint8_t n) { return n ? g(n - PINB) * 3 : PINC; }\n"
        "__attribute__((noinline)) uint8_t g(uint8_t n) { return n ? f(n - PINB) * 5 : PIND; }\n"
        "int main(void) { for (;;) PORTB = f(9); }\n",
        "calls itself: ",
    ),
    "pointer": (
        "void (*volatile f)(void);\nint main(void) { for (;;) f(); }\n",
        "main calls a function by pointer at 0x",
    ),
    "jump by pointer": (
        "void (*volatile f)(void);\n__attribute__((noinline)) void g(void) { f(); }\n"
        "int main(void) { for (;;) g(); }\n",
        "g (jumps to an address in a register|calls a function by pointer)",
    ),
    "array of a length known late": (
        "__attribute__((noinline)) void f(uint8_t n) { volatile uint8_t a[n]; a[n / 2] = a[0]; }\n"
        "int main(void) { for (;;) f(PINB); }\n",
        "f sets the stack pointer to an unknown place at 0x",
    ),
    "loop that pushes": (
        'int main(void) { for (;;) asm volatile("push r2"); }\n',
        "main comes to 0x.* with 0 and with 1 bytes",
    ),
    "return with a byte left": (
        '__attribute__((naked, used)) void f(void) { asm("push r2\\n ret"); }\n'
        'int main(void) { for (;;) asm volatile("call f"); }\n',
        "f returns at 0x.* with 1 bytes on the stack",
    ),
}


@pytest.mark.parametrize(("source", "reason"), REFUSED.values(), ids=REFUSED)
def test_what_the_code_does_not_tell_is_refused(source: str, reason: str) -> None:
    with pytest.raises(StackUnknown, match=reason):
        measure(source)
