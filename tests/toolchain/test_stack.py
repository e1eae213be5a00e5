"""The worst stack of programs: counted by hand, reached in the processor, or refused. C is the size
of a return address, two bytes on most chips and three on an ATmega2560. `main` is called from the
start-up code: C. The decoder agrees with the disassembler on every word."""

import re
import subprocess
from pathlib import Path

import pytest
from elftools.elf.elffile import ELFFile
from rig.firmware import compiled, finished, powered

from heatwright.generator.stack import StackUnknown, WorstStack, worst_stack
from heatwright.generator.stack.instructions import Instruction, decode

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
    # By its size the compiler makes room by `push`, `rcall .+0`, `sbiw`, `subi`, `sbci`, or `dec`.
    **{
        f"room for {room}": (FILL.format(room, ""), "", (2, 2 + room), (0, 0))  # Y and the frame
        for room in (1, 5, 40, 100, 256, 700)
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
    found = (stack.program, stack.interrupts, stack.total)
    assert found == (program, interrupts, program + interrupts)
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
    assert (stack.program_chain, stack.program) == (("reset", "choose", "leaf"), 2 + 2 + 20 + 2 + 1)


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
        "f sets the stack pointer to an unknown value at 0x",
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


PROGRAM = """
volatile uint8_t fired, sink;
volatile float mean = 1;
__attribute__((noinline, noclone)) void fill(uint8_t n)
{
    volatile uint8_t frame[30];
    for (uint8_t i = 0; i < 30; i++) frame[i] = n + i;
    sink = frame[n % 30];
}
__attribute__((noinline, noclone)) void wait(uint16_t n)
{
    volatile uint8_t frame[300];
    frame[n] = 1;
    for (fired = 0; !fired;) {}
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
#ifdef TIMSK0
    TIMSK1 = 1 << TOIE1; TCCR0B = 1 << CS00; TIMSK0 = 1 << TOIE0;
#else
    TIMSK = 1 << TOIE0 | 1 << TOIE1; TCCR0 = 1 << CS00;
#endif
    sei();
    for (uint8_t n = 0;; n++) sink += choose(n % 8);
}
"""


@pytest.mark.parametrize("flags", ["-Os", "-Os -flto", "-O2", "-O1 -mcall-prologues", "-O0"])
@pytest.mark.parametrize("mcu", ["atmega328p", "atmega2560", "atmega1284p", "atmega32"])
def test_the_bound_is_reached(mcu: str, flags: str) -> None:
    """It waits at its deepest place for its deepest interrupt, so the two must be equal."""
    program = compiled(PROGRAM, *flags.split(), mcu=mcu)
    avr = powered(program, mcu)
    profile = avr.profile(program)
    avr.run(0.05)
    assert profile.stack_used == worst_stack(program.path).total


SAME = {
    "adc", "add", "adiw", "call", "dec", "eor", "icall", "ijmp", "in", "inc", "jmp", "ldi", "mov",
    "movw", "out", "pop", "push", "ret", "sbc", "sbci", "sbiw", "sei", "sub", "subi",
}  # fmt: skip
FOLLOWED = {name: name for name in SAME} | {
    "rcall": "call", "rjmp": "jmp", "reti": "ret", "eijmp": "ijmp", "eicall": "icall",
    "cpse": "skip", "sbrc": "skip", "sbrs": "skip", "sbic": "skip", "sbis": "skip",
}  # fmt: skip

STORES = {"st", "std", "sts"}
READS = {"bst", "cbi", "cli", "clt", "cp", "cpc", "cpi", "nop", "sbi", "sec", "set", "sei", "sleep"}
POINTERS = {"X": 26, "Y": 28, "Z": 30}

# Address, words, mnemonic, operands, and the address that a jump or call goes to.
LINE = re.compile(
    r"^ +([0-9a-f]+):\t((?:[0-9a-f]{2} )+) *\t(\w+)\t?([^;\n]*?)\s*(?:; 0x([0-9a-f]+).*)?(?:;.*)?$",
    re.MULTILINE,
)

MUCH = """
#include <math.h>
#include <stdio.h>
volatile double x; volatile int64_t y; volatile char text[30]; void (*volatile f)(int, ...);
__attribute__((used)) void much(void)
{
    volatile char frame[300];
    x = sin(x) + atan2(x, 3) + pow(x, x) + sqrt(x) / exp(x);
    y = y / 3 * y % 7;
    sprintf((char *)text, "%d %d", (int)y, pgm_read_byte((const char *)PINC));
    if (PINB & 4) PORTB ^= 2;
    f(PINC, frame[PIND], frame);
}
"""


def listing(mcu: str) -> tuple[bytes, str]:
    elf = compiled(MUCH + PROGRAM, "-lm", mcu=mcu).path
    with elf.open("rb") as file:
        code: bytes = ELFFile(file).get_section_by_name(".text").data()
    return code, finished(["avr-objdump", "-d", str(elf)], check=True).stdout


def changed(mnemonic: str, operands: str) -> set[int]:
    if "mul" in mnemonic:
        return {0, 1}
    moved = re.search(r"([XYZ])\+(?!\d)|-([XYZ])", operands)
    found = set()
    if moved:
        pointer = POINTERS[moved.group(1) or moved.group(2)]
        found = {pointer, pointer + 1}
    if mnemonic in STORES | READS or mnemonic.startswith("br"):
        return found
    first = re.match(r"r(\d+)", operands)
    return found | ({int(first.group(1))} if first else set())


def check_operands(found: Instruction, mnemonic: str, operands: str, target: str) -> None:
    if found.name in ("call", "jmp", "branch"):
        assert found.k % 2**32 == int(target, 16)  # a table read as code leads anywhere
    elif found.name == "other":
        assert set(found.writes) >= changed(mnemonic, operands)
    elif found.name != "skip":
        registers = [int(number) for number in re.findall(r"\br(\d+)", operands)]
        constants = [int(number, 16) for number in re.findall(r"0x([0-9A-Fa-f]+)", operands)]
        assert registers == [found.d, found.r][: len(registers)]
        assert constants == [found.k][: len(constants)]


@pytest.mark.parametrize("mcu", ["atmega328p", "atmega2560"])
def test_the_decoder_agrees_with_the_disassembler(mcu: str) -> None:
    code, text = listing(mcu)
    lines = LINE.findall(text)
    assert len(lines) > 2400
    seen = set()
    for address, words, mnemonic, operands, target in lines:
        if mnemonic == "word":
            continue
        found = decode(code, int(address, 16))
        name = FOLLOWED.get(mnemonic, "branch" if mnemonic.startswith("br") else "other")
        assert (found.name, found.size) == (name, len(words.split())), (address, mnemonic)
        check_operands(found, mnemonic, operands, target)
        seen.add(found.name)
    assert seen >= SAME - {"adc", "eor", "sei"} | {"branch", "skip"}


def test_outside_the_code_nothing_is_decoded() -> None:
    for address in (-2, 1, 2):
        with pytest.raises(IndexError):
            decode(b"\x00\x00", address)
