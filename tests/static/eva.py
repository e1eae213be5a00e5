"""What Frama-C's plugin Eva is given to prove that a firmware does nothing C leaves undefined.

Eva computes what every variable may hold at every statement, over all runs. It tells each access
beyond an array or to what was never set, each overflow, shift, division and conversion whose
result C leaves open, and, as we ask for it, each number that is not finite. No alarm is a proof,
under the model that is made here:

- The C is the firmware's own, with what `points` puts in and the compiler's headers replaced by
  `avr_stubs`. Integers, pointers and alignment are the AVR's (machine `gcc_x86_16`, packed).
- The world is unknown: whatever a register brings, bytes from lines and pins among it, an EEPROM
  that holds anything, a reset from any cause. A port's latch, a UART's interrupt enables and the
  timers' masks hold what the firmware wrote; a code of the ADC has ten bits.
- Interrupts come at every point where it makes a difference (`points`): any of those whose mask bit
  is set, any number of times in any order, while they are on. `cli`, `sei` and ATOMIC_BLOCK switch
  them. An access is taken as whole: that none of several bytes is torn, is not shown here.
- Eva joins states, but for those that differ in where the text in hand ends (`text_end`), in what
  was found in a table (`found_*`) or in what a question was told (`told`). These variables are only
  written for that; no state is left out, so a proof does not rest on them.
- Conversions to a narrower type wrap, as gcc has it; so do unsigned numbers.
- What the check of the flash finds is unknown; its own reading of all the flash is left out.
- The test of the RAM may go from its first byte to its last, and is no variable's access there:
  that it gives back what it found is not shown here.
- What a record in the EEPROM gives as a number is finite (`admit`): it counts only with its CRC
  and this spec's digest, so this firmware wrote it, whose numbers are finite by this proof.
- Where `map_find` has found something, what it has noted of its arguments is what it was given
  (`admit`): it does not change them, and nothing else writes the notes.
- Four bytes that a master sends as a gain, or that a program's progress has in the EEPROM, are any
  finite number: what is not finite is refused by the comparison behind it, as a negative gain or
  a temperature beyond the limits is.
- A number of a line of G-code has seven digits before its point at most (`seven_digits`): its
  reader refuses more.
- The question whether a host may set limits is written out where a loop asks it.
- After damage (`damaged`) nothing is known of the RAM but where its pointers lead to: one turn of
  the main loop, interrupts among it, begins with any bytes. What it reads and writes by an index
  is in its array, and in the EEPROM.

Three properties are asserted: without the main loop's permit, with a fault, or where the gate finds
another permit missing, every heater's pin is off when the tick ends, at its port and at its timer;
what a loop asks of its heater is from 0 to 100 %; a fault is latched with a temperature from
-1 000 000 to 1 000 000 degC, which is why this is admitted of a record's.
"""

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from mutation.known import everything, name_of, syntax_of, text_of
from points import LATCHED, Firmware, Group, mask_bit, pointed, unlocked, with_places
from rig.firmware import board_of, finished
from tree_sitter import Node

STUBS = Path(__file__).parent / "avr_stubs"
MOST_S = 3600  # maximum time of one proof, wall clock; kiln_uno takes 8 minutes of a processor

NUMBER = re.compile(r"\(?(0[xX][0-9A-Fa-f]+|\d+)[uUlL]*\)?")
ITERATIONS = 80  # so many of each loop are looked at one by one; more are taken together
STEPS = "8, 16, 32, 64, 100, 128"  # where a bound that grows is tried to stand
FURTHER_STEPS = {
    "static const int32_t PER_SIGN = 0x80000;": 524287,  # a converter's 19 bits
    "static const int32_t MOST_BEFORE_DIGIT = 1000000;": 10000245,  # behind it, one more byte
    "static const uint32_t MOST_BEFORE_DIGIT = 99999999UL;": 999999999,
}
"""And that of what a source has, if it has it."""
FEW = 10
APART = 300  # states that are kept apart in a function that looks at them one by one

FLASH = """#include "flash.h"

#include "fault.h"

void flash_start(void)
{
}

uint8_t flash_tick(void)
{
    const uint8_t found = unknown_byte;

    return found > FAULT_LAST ? FAULT_NONE : found;
}

bool flash_is_sound(void)
{
    return unknown_byte != 0;
}
"""
"""In the place of what reads the whole flash: whatever that may find, at any time."""

Sources = Mapping[str, str]


class Proof(NamedTuple):
    alarms: tuple[str, ...]  # each with its file and line, and what must hold
    asserted: int  # properties of ours that are proven; one that is not is an alarm
    unreached: tuple[str, ...]
    """Functions that are called in the text and in no run: nothing is proven of them."""
    said: str


def proof_of(spec: str, sources: Sources, folder: Path, *, damaged: bool = False) -> Proof:
    """Have Eva look at a firmware: a spec's text or an example's name, and its files."""
    board = board_of(spec)
    registers, header = _registers(board.mcu)
    (folder / "avr").mkdir()
    (folder / "avr" / "io.h").write_text(header, encoding="utf-8")
    sources = {
        name: FLASH if name == "flash.c" else unlocked(text) for name, text in sources.items()
    }
    firmware = Firmware(sources)
    declared = " ".join(f"void interrupts_{n}(void);" for n in range(len(firmware.groups)))
    for name, text in sources.items():
        asserting = _with_ends(_mapped(name, _asserting(name, text, sources)))
        plain = re.sub(r"\bvolatile\b", "", pointed(name, asserting, firmware, ITERATIONS))
        head = f'#pragma pack(1)\n#include "harness.h"\n{declared}\n'
        (folder / name).write_text(head + plain, encoding="utf-8")
    (folder / "harness.c").write_text(
        _harness(sources, firmware.groups, registers), encoding="utf-8"
    )
    inlined = firmware.shared_functions()
    share = _run(["frama-c", "-print-share-path"], folder).strip()
    chip = f"-D__AVR_ATmega{board.mcu.removeprefix('atmega').upper()}__"
    ram = f"{board.ram_start:#x}-{board.ram_start + board.ram_bytes - 1:#x}"
    where = f"-I. -I{STUBS} -I{share}/libc {chip} -DF_CPU={board.clock_hz}UL"
    said = _run(
        [
            "frama-c", "-machdep", "gcc_x86_16", "-no-frama-c-stdlib", f"-cpp-extra-args={where}",
            *sorted(name for name in sources if name.endswith(".c")), "harness.c",
            str(STUBS / "string.c"),
            "-absolute-valid-range", ram,
            "-eva", *(("-lib-entry", "-main", "run_tick") if damaged else ("-main", "powered")),
            "-warn-special-float", "non-finite",
            "-eva-split-return", "auto", "-eva-subdivide-non-linear", "20",
            *_for(sources),
            *(("-inline-calls", ",".join(inlined)) if inlined else ()),
            "-eva-domains-function", "bitwise:gate_tick+",
            "-eva-split-return-function", ",".join(f"{name}:full" for name in _with_texts(sources)),
            "-eva-widening-delay", "1", "-eva-widening-period", "1",
            "-eva-msg-key=-initial-state,-final-states",
            "-then", "-metrics", "-metrics-eva-cover",
        ],
        folder,
    )  # fmt: skip
    return Proof(
        tuple(re.findall(r"^\[eva:alarm\] (.*(?:\n  .*)*)", said, re.MULTILINE)),
        _count("Assertions", said),
        tuple(re.findall(r"(\w+);", UNREACHED.findall(said)[0] if "Unreached" in said else "")),
        said,
    )


LATCH = "    fault.temperature_c = temperature_c;\n"
MODEST = "\\is_finite({0}.temperature_c) && -1.0e6 <= {0}.temperature_c <= 1.0e6"
GHOSTS = ("told", "text_end", "found_entry", "found_count")
ASKS = ("counts", "is_gain", "is_reachable", "is_temperature", "modbus_line_is_asked")
"""What these find out is told apart by who calls them."""
RETURN = re.compile(r"^( +)return ([^;]*);", re.M)
TOLD = r"\1if (\2) {\n told = 1; return true; }\n\1told = 0; return false;"
LONG = re.compile(r"^( +)uint8_t size = (.*\(.*);", re.M)
"""What is called there returns states that are apart, and stay so if the split is known before."""
TELLS = re.compile(
    rf"^((?:static )?bool (?:{'|'.join(ASKS)})\([^;]*?\)\n\{{\n)    return ([^;]*);", re.M
)
GIVES = ("can_go_on", "log_port_take", "log_ring_read", "nextion_port_take", "number_float",
         "number_scaled", "number_whole", "programs_read", "read", "read_amount", "read_given",
         "read_point", "take_count", "take_number", "words_count")  # fmt: skip
"""What these give, or find sound, is so only if they return true: both cases are told apart."""
SPLITS = {
    "log_talk": ("told",), "send_log": ("told",), "menu_append_program": ("told",),
    "programs_read": ("told",), "read": ("told",), "say_place": ("told",),
    "show_choosing": ("told",), "clock_wait": ("told",), "take_record": ("told",),
    "try_move": ("told",), "can_go_on": ("told",), "program_start_up": ("told",),
    "latched_fault": ("text_end",), "map_find": ("first", "count"),
    "read_bits": ("told", "found_entry"), "read_words": ("told", "found_entry"),
    "switch_coils": ("found_entry", "found_count"), "write_coils": ("told",),
    "write_registers": ("told",), "write_words": ("found_entry", "found_count"),
    "mask_write_register": ("found_entry",),
    "read_and_write_registers": ("told", "found_entry", "entry"), "put_text": ("index", "place"),
    "identity_objects": ("index", "place"),
}  # fmt: skip
"""By what else states are told apart in a function: entries of a table, and how many."""
FOUND = re.compile(
    r"map_find\(\w+, \w+, ([^;]*), (\w+)\)(?:;\n    if \(entry)? == MAP_NOT_THERE\) "
    r"\{\n.*?\n    \}\n",
    re.DOTALL,
)
IS_FOUND = re.compile(r"return ([^;?]*) \? first : MAP_NOT_THERE;")
GAIN = """const float value = gain(words);
            if (!(value >= 0.0f && value <= GAIN_MAXIMUM)) {
"""
COPIED = "    memcpy(&value, &bits, sizeof value);\n"
PROVES = "void reset_prove_watchdog(void)\n{\n"
NEEDED = {
    r"^static .*\btext_of_fault\(": (
        "-eva-slevel-function", f"text_of_fault:{APART}",
    ),
    r"^void say_float\(": ("-eva-slevel-function", f"say_float:{FEW}"),
    r"^uint8_t map_find\(": ("-eva-split-return-function", "map_find:full"),
    **{
        rf"\bbool {each}\(": (
            "-eva-split-return-function", f"{each}:full", "-eva-slevel-function", f"{each}:{FEW}",
        )
        for each in GIVES
    },
    **{rf"\bbool {each}\(": ("-eva-slevel-function", f"{each}:{FEW}") for each in ASKS},
}  # fmt: skip
"""What a function needs, where there is one of the name: each text is looked at alone."""


def _for(sources: Sources) -> list[str]:
    everything = "\n".join(sources.values())
    found = [each for name, each in NEEDED.items() if re.search(name, everything, re.MULTILINE)]
    return [word for each in found for word in each]


UNREACHED = re.compile(r"^  Unreached functions \(\d+\) =\n((?:    .*\n)*)", re.MULTILINE)


def _count(what: str, said: str) -> int:
    found = re.search(rf"{what} +(\d+)", said)
    return int(found[1]) if found else 0


def _run(command: list[str], folder: Path) -> str:
    there = {**os.environ, "PWD": str(folder)}  # where Frama-C looks for files
    done = finished(command, cwd=folder, env=there, timeout=MOST_S)
    assert done.returncode == 0, done.stdout[-3000:]
    return done.stdout


def _texts(text: str) -> list[Node]:
    return [
        each
        for each in syntax_of(text.encode()).children
        if each.type == "function_definition"
        and re.search(rb"\bchar (\*|\w+\[)", each.text or b"") is not None
    ]


def _with_texts(sources: Sources) -> list[str]:
    names = {
        name_of(each.child_by_field_name("declarator"))
        for text in sources.values()
        for each in _texts(text)
    }
    return sorted(names | {"static_strlen", "static_strcpy", "static_strcat"})


WORD = re.compile(r"return (WORD_\w+);")  # what a line of G-code has: only a number is given
FINDS = re.compile(
    r"\b(words_find|words_count|take_number|read_number|take_count|number_\w+|read_point|read_amount"
    r"|nextion_port_take)\("
)
HEARS = re.compile(r"^(?:static )?\w+ \w+\([^;{]*\)\n\{\n(?:.+\n|\n)*?\}", re.M)


def _heard(text: str) -> str:
    """Have Eva tell states apart, in a reader of commands, by what it has found in one."""
    text = WORD.sub(r"{ told = \1; return \1; }", text)
    for found in HEARS.findall(text):
        if FINDS.search(found):
            text = text.replace(found, _split(found, ("told",)))
    return text.replace("(int32_t)wanted", "(int32_t)seven_digits(wanted)")


def _telling(text: str) -> str:
    """Have Eva tell states apart by what was found out, and by entries of tables."""
    if "gcode_words.h" in text or "nextion_port.h" in text or "nextion_numbers.h" in text:
        text = _heard(text)
    text = TELLS.sub(
        r"\1    if (\2) {\n told = 1; return true; }\n    told = 0; return false;", text
    )
    for name in GIVES:
        for found in _whole(name).findall(text):
            text = text.replace(found, RETURN.sub(TOLD, found))
    for name, splits in SPLITS.items():
        for found in _whole(name).findall(text):
            text = text.replace(found, _split(found, splits))
    return text


def _with_ends(text: str) -> str:
    """Have Eva tell states apart, in functions that have texts in hand, by where the text ends
    that was made or found last, or by how long it is."""
    text = _telling(text)
    text = LONG.sub(r"\1uint8_t size = 0;\n\1size = \2;", text)
    puts: dict[int, str] = {}
    for function in _texts(text):
        body = function.child_by_field_name("body")
        assert body is not None
        written = text_of(function)
        is_given_one = re.search(r"\bchar (\*|\w+\[)", written.split("{")[0])
        new = "" if is_given_one else "text_end = 0; "
        puts[body.start_byte + 1] = f" {new}/*@ dynamic_split text_end; */ ;"
        for each in everything(body):
            said = text_of(each)
            if ended := re.fullmatch(r"([^;=]+) = '\\0';", said):
                puts[each.end_byte] = f" ENDS(&({ended[1]}));"
            if found := re.match(r"uint8_t (length|size)\b.*;", said):
                puts[each.end_byte] = f" /*@ dynamic_split {found[1]}; */ ;"
            if said == "return size;" and "(char *text, " in written:
                puts[each.start_byte] = "{ ENDS(text + size); "
                puts[each.end_byte] = " }"
            if each.type == "return_statement" and re.match(r"[\w ]*\bchar \*", written):
                puts[each.start_byte] = f"{{ ENDS({said[len('return ') : -1]}); "
                puts[each.end_byte] = " }"
    return with_places(text, puts)


def _whole(name: str) -> re.Pattern[str]:
    """The function of a name; what gives something says whether it did."""
    kind = "bool" if name in GIVES else r"\w+"
    return re.compile(rf"^(?:static )?{kind} {name}\([^;]*?\)\n\{{\n.*?^\}}", re.M | re.S)


def _mapped(name: str, text: str) -> str:
    """Return a file with what has to be known of a Modbus slave's table of registers."""
    if name == "modbus_map.c" and GAIN in text:
        return _once(text, COPIED, "    value = any_finite();\n").replace(
            COPIED, "    (void)bits;\n"
        )
    if name == "modbus_values.c":
        text = _once(text, "uint8_t first = 0;\n", "    found_entry = MAP_NOT_THERE;\n")
        assert IS_FOUND.search(text), "what is found?"
        found = "found_entry = first; found_address = address; found_count = count; return first;"
        return IS_FOUND.sub(rf"if (\1) {{ {found} }} return MAP_NOT_THERE;", text)
    return FOUND.sub(_known, text) if name == "modbus.c" else text


def _known(found: re.Match[str]) -> str:
    """What a table was looked through for, is what `map_find` has put there."""
    asked = {"found_address": found[1], "found_count": found[2]}
    known = " && ".join(f"{put} == {name}" for put, name in asked.items() if name.isalpha())
    return f"{found[0]}    //@ admit {known};\n" if known else found[0]


def _split(function: str, names: tuple[str, ...]) -> str:
    """Have Eva tell states apart by variables, from where each of them is set first."""
    for name in names:
        split = f" /*@ dynamic_split {name}; */ ;"
        declared = re.search(rf"^    (const )?uint\d+_t {name} = [^;]*;", function, re.MULTILINE)
        if declared:
            function = function.replace(declared[0], declared[0] + split)
        else:
            new = f" {name} = 0;" if name in GHOSTS else ""
            function = function.replace("\n{\n", f"\n{{\n{new}{split}", 1)
    return function


def _asserting(name: str, text: str, sources: Sources) -> str:
    """Return a file with what is asserted in it, and what is admitted of records."""
    if re.fullmatch(r"loop_\w+\.c", name):
        text = _written_out(text, sources)
    if name == "reset.c" and PROVES in text:  # what a start has left for the one after it
        word = "(uint16_t)((uint16_t)unknown_byte << 8 | unknown_byte)"
        return _once(text, PROVES, f"    awaited = {word};\n    waited = unknown_byte;\n")
    if name in ("settings.c", "program.c"):
        return _admitting(name, text, sources)
    if name == "fault.c":
        return _once(text, LATCH, f"    //@ assert modest: {MODEST.format('fault')};\n")
    if name.startswith("current_"):  # so that Eva knows by it what was compared
        return re.sub(r"const bool told = (.*);", r"/*@ split \1; */ ; \g<0>", text)
    if name == "gate.c":
        text = _once(text, _line(text, "const bool healthy = "), "    //@ split healthy;\n")
        for each in re.findall(r"^    output_(\w+)_tick\(\w+_permitted", text, re.MULTILINE):
            text = _once(text, _line(text, f"output_{each}_tick("), _off(each, sources))
            permitted = rf"^    output_{each}_tick\((.*)\);"
            text = re.sub(permitted, _PERMITTED.format(each), text, flags=re.MULTILINE)
        return text
    return re.sub(
        r"^( +)(output_\w+_set\((loop_\w+\.duty_percent)\);)",
        r"\1//@ assert duty: 0 <= \3 <= 100;\n\1\2", text, flags=re.MULTILINE,
    )  # fmt: skip


_PERMITTED = (
    r"    const bool permits_{0} = \1;\n"
    r"    //@ assert permits_{0}: permits_{0} == 0 || healthy != 0;\n"
    r"    //@ split permits_{0};\n"
    r"    output_{0}_tick(permits_{0});"
)


def _off(heater: str, sources: Sources) -> str:
    """Return what is asserted behind the tick of a heater: without permit its port is at the off
    level, and no timer's compare output has the pin."""
    off = rf"pin_output_{heater}_off\(void\)\n\{{\n.*?(PORT\w) (&|\|)= .*?<< (\d)"
    found = re.search(off, sources["pins.h"], re.DOTALL)
    assert found is not None, f"how is {heater} switched off?"
    port, way, bit = found.groups()
    claims = [f"({port} & {1 << int(bit)}u) {'==' if way == '&' else '!='} 0"]
    compares = re.findall(r"(TCCR\w+) \|= (.*);", sources[f"output_{heater}.c"])
    claims += [f"({register} & ({bits})) == 0" for register, bits in sorted(set(compares))]
    return (
        f"    const bool off_{heater} = {' && '.join(claims)};\n"
        f"    //@ assert off_{heater}: permits_{heater} != 0 || off_{heater} != 0;\n"
    )


MAY = re.compile(r"^bool (settings_may_limit_\w+)(\([^)]*\))\n\{\n    return ([^;]*);\n\}", re.M)


def _written_out(text: str, sources: Sources) -> str:
    """Return a file with the question for limits written out where it is asked: Eva knows then
    what it says of the variables themselves, not of their copies."""
    asked = MAY.findall(sources.get("settings.c", ""))
    macros = "".join(
        "#define {}{} ({})\n".format(name, given.replace("float ", ""), said.replace("\n", " "))
        for name, given, said in asked
    )
    head, include, rest = text.rpartition("#include")
    line, end, rest = rest.partition("\n")
    return head + include + line + end + macros + rest


def _admitting(name: str, text: str, sources: Sources) -> str:
    """Return a file with what is known of the numbers that it finds in the EEPROM."""
    if name == "settings.c":
        known = "".join(
            f"    //@ admit \\is_finite(record.kept.{each});\n" for each in _floats("kept", text)
        )
        known += f"    //@ admit {MODEST.format('record.fault')};\n"
        return _once(text, "    record = candidate.record;\n", known)
    known = "".join(
        f"    record.{each} = any_finite();\n"
        for each in _floats("progress_record", sources["progress.h"])
    )
    found = "    if (!progress_found(&record)) {\n        return;\n    }\n"
    return _once(text, found, known)


def _floats(struct: str, text: str) -> list[str]:
    found = re.search(rf"^struct {struct} \{{\n(.*?)^\}};", text, re.MULTILINE | re.DOTALL)
    return re.findall(r"^    float (\w+);", found[1] if found else "", re.MULTILINE)


def _line(text: str, begin: str) -> str:
    return next(f"{line}\n" for line in text.splitlines() if line.strip().startswith(begin))


def _once(text: str, behind: str, new: str) -> str:
    assert text.count(behind) == 1, behind
    return text.replace(behind, behind + new)


def _registers(mcu: str) -> tuple[dict[str, str], str]:
    """Return the chip's registers with their bits, and an <avr/io.h> with each as a variable."""
    said = _run(
        ["avr-gcc", f"-mmcu={mcu}", "-dM", "-E", "-include", "avr/io.h", "-x", "c", "/dev/null"],
        STUBS,
    )
    bits, lines = {}, []
    for name, body in sorted(re.findall(r"^#define ([A-Z]\w*) (.+)$", said, re.MULTILINE)):
        if register := re.fullmatch(r"_SFR_(?:IO|MEM)(8|16) ?\(\w+\)", body):
            bits[name] = register[1]
        elif NUMBER.fullmatch(body) or f"#define {body} _SFR" in said:
            lines.append(f"#define {name} {body}")
    del bits["ADC"]
    lines = [f"extern {_declared(name, bits)};" for name in bits] + lines
    lines.append("#define ADC ((uint16_t)(ADCW & 0x3FFu)) /* ten bits */")
    head = "#ifndef STATIC_IO_H\n#define STATIC_IO_H\n#include <stdint.h>\n"
    return bits, head + "\n".join(lines) + "\n#endif\n"


def _declared(name: str, bits: Mapping[str, str]) -> str:
    unknown = "" if LATCHED.match(name) else "__volatile__ "
    return f"{unknown}uint{bits[name]}_t {name}"


def _mask(vector: str, registers: Mapping[str, str]) -> str:
    """Return what enables an interrupt, as C."""
    bit = mask_bit(vector)
    if not bit:  # whatever has no routine
        return "1"
    number = re.sub(r"\D", "", bit)
    if bit.startswith("OCIE"):
        register = f"TIMSK{number}" if f"TIMSK{number}" in registers else "TIMSK"
    elif bit == "ADIE":
        register = "ADCSRA"
    elif "UCSR0B" in registers:
        register, bit = f"UCSR{number or 0}B", bit if number else f"{bit}0"
    else:
        register = "UCSRB"
    return f"{register} & (1u << {bit})"


def _coming(number: int, vectors: Sequence[str], registers: Mapping[str, str]) -> str:
    """Return the C for interrupts of a group: those that are enabled, as often as may be."""
    cases = "".join(
        f"        case {n}:\n            if ({_mask(vector, registers)}) {{\n"
        f"                {vector}();\n            }}\n            break;\n"
        for n, vector in enumerate(vectors)
    )
    routines = "".join(f"void {vector}(void);\n" for vector in vectors)
    return f"""{routines}
void interrupts_{number}(void)
{{
    interrupts_on = 0;
    while (unknown_byte) {{
        switch (unknown_byte) {{
{cases}        default:
            break;
        }}
    }}
    interrupts_on = 1;
}}

"""


def _harness(sources: Sources, groups: Sequence[Group], registers: Mapping[str, str]) -> str:
    come = "".join(_coming(n, each.vectors, registers) for n, each in enumerate(groups))
    unknown = "".join(f"    {name} = unknown_byte;\n" for name in registers if name[:4] == "PORT")
    variables = "".join(f"{_declared(name, registers)};\n" for name in registers)
    everything_said = "".join(sources.values())
    further = [f", {step}" for text, step in FURTHER_STEPS.items() if text in everything_said]
    steps = STEPS + "".join(further)
    return f"""#include <avr/io.h>
#include "harness.h"

{variables}
__volatile__ uint8_t unknown_byte;
uint8_t interrupts_on;
size_t text_end;
uint8_t told;
uint8_t found_entry;
uint16_t found_address;
uint16_t found_count;
extern uint8_t reset_cause;
extern uint16_t reset_hang_mark;
int main(void);

{come}void powered(void)
{{
    /*@ widen_hints global:"all", {steps}; */
{unknown}    reset_cause = unknown_byte;
    reset_hang_mark = (uint16_t)((uint16_t)unknown_byte << 8 | unknown_byte);
    main();
}}
"""
