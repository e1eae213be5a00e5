"""The worst stack of small programs whose depth is counted by hand, and what is refused.

`+` in a comment is one byte on the stack; C is the size of a return address, two bytes on most
chips and three on an ATmega2560. `main` is called from the start-up code: C.
"""

import subprocess
from pathlib import Path

import pytest
from rig.avr import compiled

from heatwright.generator.stack import StackUnknown, WorstStack, worst_stack

C = {"atmega328p": 2, "atmega2560": 3, "atmega16": 2}
LOOP = "int main(void) { for (;;); }\n"
FILL = """
__attribute__((noinline)) void fill(uint16_t i)
{{ volatile uint8_t frame[{0}]; {1} frame[i] = 1; frame[i / 2] = frame[i]; }}
int main(void) {{ for (;;) fill(PINB); }}
"""
SAVED = ", ".join(f'"r{number}"' for number in range(8, 18))

# Source, flags; of the program the calls and all else in bytes, of the interrupts the same.
COUNTED = {
    "main alone": (LOOP, "", (1, 0), (0, 0)),
    "calls and pushes": (
        r"""
        __attribute__((naked, used)) void leaf(void) { asm("push r2\n pop r2\n ret"); }
        __attribute__((naked, used)) void deep(void)
        { asm("push r2\n push r3\n push r4\n call leaf\n pop r4\n pop r3\n pop r2\n ret"); }
        int main(void) { for (;;) { asm("call leaf"); asm("call deep"); } }
        """,
        "", (3, 3 + 1), (0, 0),
    ),
    # The compiler makes room by `push`, `rcall .+0`, `sbiw` or `subi` and `sbci`, by its size.
    **{
        f"room for {room}": (FILL.format(room, ""), "", (2, 2 + room), (0, 0))  # Y and the frame
        for room in (1, 5, 40, 100, 700)
    },
    "a shared prologue": (
        FILL.format(40, f'asm volatile("" ::: {SAVED});'), "-mcall-prologues", (2, 12 + 40), (0, 0)
    ),
    # n and two longs; sum keeps Y to find them.
    "arguments on the stack": (
        r"""
        __attribute__((noinline, noclone)) uint8_t sum(uint8_t n, ...)
        { asm volatile(""); return n; }
        int main(void) { for (;;) PORTB = sum(3, 1L, 2L); }
        """,
        "", (2, 1 + 4 + 4 + 2), (0, 0),
    ),
    "the deepest interrupt": (
        r"""
        ISR(TIMER0_OVF_vect, ISR_NAKED) { asm("push r2\n pop r2\n reti"); }
        ISR(TIMER1_OVF_vect, ISR_NAKED) { asm("push r2\n push r3\n pop r3\n pop r2\n reti"); }
        """ + LOOP,
        "", (1, 0), (1, 2),
    ),
    "an interrupt that lets others in": (
        r"""
        ISR(TIMER0_OVF_vect, ISR_NAKED) { asm("sei\n push r2\n pop r2\n reti"); }
        ISR(TIMER1_OVF_vect, ISR_NAKED) { asm("push r2\n push r3\n pop r3\n pop r2\n reti"); }
        ISR(TIMER2_OVF_vect, ISR_NAKED) { asm("push r2\n pop r2\n reti"); }
        """ + LOOP,
        "", (1, 0), (2, 1 + 2),
    ),
}  # fmt: skip


def measure(source: str, mcu: str = "atmega328p", *flags: str) -> WorstStack:
    return worst_stack(compiled(source, "-lm", *flags, mcu=mcu).path)


@pytest.mark.parametrize("case", COUNTED)
@pytest.mark.parametrize("mcu", C)
def test_the_stack_is_what_is_counted_by_hand(mcu: str, case: str) -> None:
    source, flags, *counted = COUNTED[case]
    stack = measure(source, mcu, *flags.split())
    program, interrupts = (calls * C[mcu] + rest for calls, rest in counted)
    assert (stack.program, stack.interrupts) == (program, interrupts)
    assert stack.total == program + interrupts
    if case == "calls and pushes":
        assert stack.program_chain == ("reset", "main", "deep", "leaf")


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
