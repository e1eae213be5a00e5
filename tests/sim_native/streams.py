"""Random instruction streams: a flash image holds many of them, each leaves a record in RAM. A
stream begins with given registers, flags and stack pointer, and runs forward to its end. Its record
is what it has written to memory and to its stack, then all registers, SREG, SP, RAMPZ, and timer 1,
which counts cycles. Whoever runs the image on another processor compares the RAM."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from functools import partial
from random import Random

H, S, V, N, Z, C = 5, 4, 3, 2, 1, 0  # flags of SREG
SPL, SPH, SREG, RAMPZ, EIND, GPIOR0 = 0x3D, 0x3E, 0x3F, 0x3B, 0x3C, 0x1E
TCCR1B, TCNT1L, TCNT1H = 0x81, 0x84, 0x85
POINTERS = {"X": 26, "Y": 28, "Z": 30}

# The manual's own patterns. Each letter is a field, random unless it is given.
SIMPLE = {
    "add": "000011rdddddrrrr", "adc": "000111rdddddrrrr", "sub": "000110rdddddrrrr",
    "sbc": "000010rdddddrrrr", "and": "001000rdddddrrrr", "or": "001010rdddddrrrr",
    "eor": "001001rdddddrrrr", "mov": "001011rdddddrrrr", "cp": "000101rdddddrrrr",
    "cpc": "000001rdddddrrrr", "mul": "100111rdddddrrrr", "movw": "00000001ddddrrrr",
    "muls": "00000010ddddrrrr", "mulsu": "000000110ddd0rrr", "fmul": "000000110ddd1rrr",
    "fmuls": "000000111ddd0rrr", "fmulsu": "000000111ddd1rrr", "cpi": "0011KKKKddddKKKK",
    "subi": "0101KKKKddddKKKK", "sbci": "0100KKKKddddKKKK", "ori": "0110KKKKddddKKKK",
    "andi": "0111KKKKddddKKKK", "ldi": "1110KKKKddddKKKK", "adiw": "10010110KKddKKKK",
    "sbiw": "10010111KKddKKKK", "com": "1001010ddddd0000", "neg": "1001010ddddd0001",
    "swap": "1001010ddddd0010", "inc": "1001010ddddd0011", "asr": "1001010ddddd0101",
    "lsr": "1001010ddddd0110", "ror": "1001010ddddd0111", "dec": "1001010ddddd1010",
    "bset": "100101000sss1000", "bclr": "100101001sss1000", "bst": "1111101ddddd0bbb",
    "bld": "1111100ddddd0bbb", "nop": "0000000000000000",
}  # fmt: skip
MODES = {"X": "1100", "X+": "1101", "-X": "1110", "Y+": "1001", "-Y": "1010", "Z+": "0001",
         "-Z": "0010"}  # fmt: skip
INDIRECT = {
    f"{kind} {mode}": f"100100{store}ddddd{code}"
    for store, kind in enumerate(("ld", "st"))
    for mode, code in MODES.items()
} | {
    f"{kind} {pointer}q": f"10q0qq{store}ddddd{number}qqq"
    for store, kind in enumerate(("ldd", "std"))
    for number, pointer in enumerate("ZY")
}
FLASH = {"lpm r0": "1001010111001000", "lpm": "1001000ddddd0100", "lpm+": "1001000ddddd0101"}
FAR_FLASH = {"elpm r0": "1001010111011000", "elpm": "1001000ddddd0110", "elpm+": "1001000ddddd0111"}
SKIPS = {"cpse": "000100rdddddrrrr", "sbrc": "1111110rrrrr0bbb", "sbrs": "1111111rrrrr0bbb"}
IO_SKIPS = {"sbic": "10011001AAAAAbbb", "sbis": "10011011AAAAAbbb"}
IO_BITS = {"sbi": "10011010AAAAAbbb", "cbi": "10011000AAAAAbbb"}
JUMPS = {
    "rjmp": "1100kkkkkkkkkkkk", "rcall": "1101kkkkkkkkkkkk", "jmp": "1001010kkkkk110k",
    "call": "1001010kkkkk111k", "ijmp": "1001010000001001", "icall": "1001010100001001",
    "eijmp": "1001010000011001", "eicall": "1001010100011001",
}  # fmt: skip
OTHERS = {
    "in": "10110AAdddddAAAA", "out": "10111AArrrrrAAAA", "lds": "1001000ddddd0000",
    "sts": "1001001rrrrr0000", "push": "1001001rrrrr1111", "pop": "1001000ddddd1111",
    "ret": "1001010100001000", "brbs": "111100kkkkkkksss", "brbc": "111101kkkkkkksss",
}  # fmt: skip
PATTERNS = SIMPLE | INDIRECT | FLASH | FAR_FLASH | SKIPS | IO_SKIPS | IO_BITS | JUMPS | OTHERS

MEMORY, STACK = 48, 32
RECORD = MEMORY + STACK + 32 + 6  # bytes; the last are SREG, SPL, SPH, RAMPZ, TCNT1L, TCNT1H
REGISTERS = MEMORY + STACK
FILL_STEP = 59
LENGTH = 24  # units of a stream, of one to eight instructions each


@dataclass(frozen=True)
class Chip:
    mcu: str
    ram_start: int
    ram_end: int
    flash_bytes: int

    @property
    def far(self) -> bool:
        return self.flash_bytes > 0x20000

    @property
    def streams(self) -> int:
        """How many records fit; the last byte of RAM tells that the program is over."""
        return (self.ram_end - self.ram_start) // RECORD


BOTH = Chip("atmega328p", 0x100, 0x8FF, 0x8000), Chip("atmega2560", 0x200, 0x21FF, 0x40000)
CHIPS = {chip.mcu: chip for chip in BOTH}


@dataclass(frozen=True)
class Errors:
    """What a judge gets wrong or lacks; the streams for it keep clear of just that."""

    flags: Mapping[str, Collection[int]] = field(default_factory=dict)
    """By instruction: flags that come out wrong. They are cleared right after it."""
    cycles: Collection[str] = ()  # these take a wrong time; a stream's with one is not compared
    wide_skips: bool = False  # ADIW and SBIW with K & 12 == 12 are two words where they are skipped
    pages: int = 4  # pages of 64 KB that ELPM reaches
    registers: bool = True  # whether it has the I/O register GPIOR0
    timed: bool = True  # whether it counts cycles at all


@dataclass
class Image:
    chip: Chip
    words: list[int]
    end: int  # word address at which it stays
    names: list[list[str]]  # the instructions of each stream, in the order of the code
    untimed: set[int]  # streams whose time the judge gets wrong

    @property
    def flash(self) -> bytes:
        return b"".join(word.to_bytes(2, "little") for word in self.words)


def image(chip: Chip, seed: int, errors: Errors) -> Image:
    return _Writer(chip, Random(seed), errors).whole()  # noqa: S311 - no secret


class _Writer:
    def __init__(self, chip: Chip, rng: Random, errors: Errors) -> None:
        self.chip, self.rng, self.errors = chip, rng, errors
        self.words: list[int] = []
        self.names: list[list[str]] = []
        self.untimed: set[int] = set()
        self.base = self.depth = 0
        self.skipped = False

    def emit(self, name: str, **fields: int) -> None:
        pattern, word = PATTERNS[name], 0
        if name in IO_SKIPS or name in IO_BITS:
            fields["A"] = GPIOR0
        left = {letter: pattern.count(letter) for letter in pattern if letter.isalpha()}
        for letter, count in left.items():
            fields.setdefault(letter, self.rng.getrandbits(count))
        for character in pattern:
            if character.isalpha():
                left[character] -= 1
            bit = fields[character] >> left[character] if character.isalpha() else int(character)
            word = word << 1 | bit & 1
        if self.skipped and self.errors.wide_skips and word & 0xFE0C == 0x960C:
            word &= ~8
        self.skipped = name in SKIPS or name in IO_SKIPS
        self.words.append(word)
        if self.names:
            self.names[-1].append(name)
            if name in self.errors.cycles:
                self.untimed.add(len(self.names) - 1)
        for flag in self.errors.flags.get(name, ()):
            self.words.append(0x9488 | flag << 4)

    def far(self, name: str, address: int, **fields: int) -> None:
        self.emit(name, **fields)
        self.words.append(address)

    def load(self, register: int, value: int) -> None:
        self.emit("ldi", d=register - 16, K=value)

    def point(self, pointer: str, address: int) -> None:
        register = POINTERS[pointer]
        self.load(register, address & 255)
        self.load(register + 1, address >> 8)

    def put(self, io: int, value: int) -> None:
        self.load(16, value)
        self.emit("out", A=io, r=16)

    def whole(self) -> Image:
        self.begin()
        for number in range(self.chip.streams):
            self.names.append([])
            self.base = self.chip.ram_start + number * RECORD
            self.stream()
        self.names, names = [], self.names
        self.load(16, 0xA5)
        self.far("sts", self.chip.ram_end, r=16)
        end = len(self.words)
        self.emit("rjmp", k=-1)
        room = self.chip.flash_bytes // 2 - len(self.words)
        self.words += [self.rng.getrandbits(16) for _ in range(room)]
        return Image(self.chip, self.words, end, names, self.untimed)

    def begin(self) -> None:
        """Let timer 1 count cycles, and fill the RAM: at power-on its contents are arbitrary."""
        self.load(16, 1)
        self.far("sts", TCCR1B, r=16)
        self.point("X", self.chip.ram_start)
        self.load(17, (self.chip.ram_end + 1) >> 8)
        loop = len(self.words)
        self.emit("st X+", d=16)
        self.emit("subi", d=0, K=256 - FILL_STEP)
        self.emit("cpi", d=10, K=(self.chip.ram_end + 1) & 255)
        self.emit("cpc", d=27, r=17)
        self.emit("brbc", s=Z, k=loop - len(self.words) - 1)

    def stream(self) -> None:
        self.put(SPL, (self.base + MEMORY + STACK // 2) & 255)
        self.put(SPH, (self.base + MEMORY + STACK // 2) >> 8)
        if self.chip.far:
            self.put(RAMPZ, 0)
        self.put(SREG, self.value())
        for register in range(16):
            self.load(16, self.value())
            self.emit("mov", d=register, r=16)
        for register in range(16, 32):
            self.load(register, self.value())
        self.names[-1].clear()
        self.untimed.discard(len(self.names) - 1)
        self.depth = 0
        for _ in range(LENGTH):
            self.unit()
        made = list(self.names[-1])
        self.record()
        self.names[-1] = made

    def value(self) -> int:
        return self.rng.choice((0, 1, 0x7F, 0x80, 0xFF, *[self.rng.getrandbits(8)] * 4))

    def record(self) -> None:
        at = self.base + REGISTERS
        for register in range(32):
            self.far("sts", at + register, r=register)
        for offset, io in enumerate((SREG, SPL, SPH, *([RAMPZ] if self.chip.far else []))):
            self.emit("in", A=io, d=0)
            self.far("sts", at + 32 + offset, r=0)
        for offset, address in enumerate((TCNT1L, TCNT1H)):
            self.far("lds", address, d=0)
            self.far("sts", at + 36 + offset, r=0)

    def unit(self) -> None:
        units = [self.simple] * 6 + [self.memory] * 4 + [self.skip] * 4 + [
            self.branch, self.jump, self.call, self.stack, self.flash, self.registers, self.io,
        ]  # fmt: skip
        self.rng.choice(units)()

    def simple(self) -> None:
        self.emit(self.rng.choice(sorted(SIMPLE)))

    def memory(self) -> None:
        if self.rng.random() < 0.3:
            self.direct()
            return
        name = self.rng.choice(sorted(INDIRECT))
        pointer = next(letter for letter in name if letter in POINTERS)
        displacement = self.rng.randrange(40) if name.endswith("q") else 0
        room = MEMORY - 2 - displacement
        self.point(pointer, self.base + 1 + self.rng.randrange(room))
        own = POINTERS[pointer]  # "the result of these combinations is undefined" (LD, ST)
        d = self.rng.choice([n for n in range(32) if n not in {own, own + 1}])
        self.emit(name, d=d, **({"q": displacement} if name.endswith("q") else {}))

    def direct(self) -> None:
        self.far(self.rng.choice(("lds", "sts")), self.base + self.rng.randrange(MEMORY))

    def skip(self) -> None:
        """A skip over one or two words, and often over ADIW or SBIW."""
        kinds = IO_SKIPS if self.errors.registers and self.rng.random() < 0.3 else SKIPS
        self.emit(self.rng.choice(sorted(kinds)))
        jump = partial(self.far, "jmp", len(self.words) + 2, k=0)
        wide = partial(self.emit, self.rng.choice(("adiw", "sbiw")))
        self.rng.choice((self.direct, jump, wide, self.simple, self.simple))()

    def over(self, name: str, **fields: int) -> None:
        place = len(self.words)
        self.emit(name, **fields)
        for _ in range(self.rng.randrange(4)):
            self.simple()
        self.words[place] |= (len(self.words) - place - 1) << (3 if name.startswith("br") else 0)

    def branch(self) -> None:
        self.over(self.rng.choice(("brbs", "brbc")), k=0)

    def jump(self) -> None:
        name = self.rng.choice(("rjmp", "jmp", "ijmp", *(["eijmp"] if self.chip.far else [])))
        if name == "rjmp":
            self.over(name, k=0)
            return
        target = self.go(name, self.rng.randrange(3))
        self.words += [self.rng.getrandbits(16)] * (target - len(self.words))

    def go(self, name: str, behind: int) -> int:
        if name in {"eijmp", "eicall"}:
            self.put(EIND, 0)
        if name in {"jmp", "call"}:
            target = len(self.words) + 2 + behind
            self.far(name, target, k=0)
        else:
            target = len(self.words) + 2 + 1 + behind
            self.point("Z", target)
            self.emit(name)
        return target

    def call(self) -> None:
        """A call of a function of one instruction, which lies right behind."""
        size = 3 if self.chip.far else 2
        if self.depth + size > STACK // 2 - 4:
            return
        name = self.rng.choice(("rcall", "call", "icall", *(["eicall"] if self.chip.far else [])))
        if name == "rcall":
            self.emit(name, k=1)
        else:
            self.go(name, 1)
        place = len(self.words)
        self.emit("rjmp", k=0)
        self.simple()
        self.emit("ret")
        self.words[place] |= len(self.words) - place - 1

    def stack(self) -> None:
        name = self.rng.choice(("push", "pop"))
        change = 1 if name == "push" else -1
        if abs(self.depth + change) < STACK // 2 - 8:
            self.depth += change
            self.emit(name)

    def flash(self) -> None:
        far = self.chip.far and self.rng.random() < 0.6
        page = self.rng.randrange(self.errors.pages)
        if far:
            self.put(RAMPZ, page)
        last = 0xFFFF - (page == self.errors.pages - 1)  # behind the flash is nobody's to say
        edge = self.rng.choice((0, 1, 0x7FFF, last, self.rng.getrandbits(15)))
        self.point("Z", edge & (self.chip.flash_bytes - 1))
        d = self.rng.randrange(30)  # LPM r30 and r31, Z+: "undefined"
        name = self.rng.choice(sorted(FAR_FLASH if far else FLASH))
        self.emit(name, **({} if name.endswith("r0") else {"d": d}))

    def registers(self) -> None:
        """IN and OUT of what belongs to the core."""
        name, place = self.rng.choice((("out", SREG), *(("in", each) for each in (SREG, SPL, SPH))))
        self.emit(name, A=place)

    def io(self) -> None:
        if self.errors.registers:
            self.emit(self.rng.choice(("in", "out", *IO_BITS)), A=GPIOR0)
