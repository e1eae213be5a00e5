"""Interfaces: how an operator or a computer sees and sets the loops.

Other code uses these properties of a model, and never tests its kind:
line -- its serial line; shield -- its board with keys, if it is one; is_host -- a program at the
other end sets setpoints; acknowledges -- somebody can acknowledge faults with it;
named_pins -- where the spec names pins for it, and for what purpose; named_loops -- where the spec
names loops for it.
"""

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field, StrictBool

from heatwright.spec.algorithms import LARGEST_GAIN
from heatwright.spec.base import (
    BareNumber,
    Filled,
    Least,
    Model,
    PinName,
    ReadOnly,
    Reference,
    WholeNumber,
)
from heatwright.spec.loading.suggest import listed
from heatwright.spec.problems import Checked, Path, refuse, shown
from heatwright.spec.quantity import Quantity
from heatwright.spec.registry import with_brought
from heatwright.spec.units import DIFFERENCE, DURATION

FASTEST_HOST = 250_000
"""Fastest baud rate of hosts of 3D printers: a byte each 40 µs, whose interrupt takes some 5 µs."""


BUS_BAUDS = (1200, 2400, 4800, 9600, 14400, 19200, 28800, 38400, 57600, 76800, 115_200)
"""Baud rates that masters offer."""


DISPLAY_BAUDS = (2400, 4800, 9600, 19200, 31250, 38400, 57600, 115_200)
"""Baud rates that both a Nextion display and a board can be set to."""
FASTER_DISPLAY_BAUDS = (230_400, 250_000, 256_000, 512_000, 921_600)
"""Baud rates to which a display may have been set before."""

USUAL_BAUDS = (9600, 19200, 38400, 57600, 115200, 250000, 500000, 1000000)
"""Baud rates that programs on a computer offer."""
HOST_BAUDS = tuple(baud for baud in USUAL_BAUDS if baud <= FASTEST_HOST)

NamedPins = tuple[tuple[Path, str, str], ...]
"""For each pin: the keys of the interface that name it, the pin, and its purpose."""


class Line(NamedTuple):
    """A serial line of an interface."""

    baud: int
    usual_bauds: tuple[int, ...]
    """Baud rates that the other end of the line may offer."""
    called: str | None
    """Name in a list of level converters; None if the line's other end has the pins' levels."""
    receives: bool = True
    port: int = 0
    can_move: bool = False
    """Whether the spec may choose the serial port."""
    parity: Literal["even", "odd", "none"] = "none"
    stop_bits: int = 1

    @property
    def form(self) -> str:
        """The format of a character in the usual form, such as `8E1`."""
        return f"8{self.parity[0].upper()}{self.stop_bits}"

    @property
    def told(self) -> str:
        """Speed and format of the line, such as `19200 baud, 8E1`."""
        return f"{self.baud} baud, {self.form}"


class Shield(NamedTuple):
    """A board that is put on top: the pins that it uses, with purposes, and the pin of its keys."""

    pins: Mapping[str, str]
    keys: str


LCD_KEYPAD = Shield(
    {
        **{f"D{line}": f"the display's data {line}" for line in range(4, 8)},
        "D8": "the display's RS",
        "D9": "the display's E",
        "D10": "the display's backlight",
        "A0": "the keys",
    },
    keys="A0",
)
"""An HD44780 in 4-bit mode, which is not read back, and five keys on one analog pin."""


class Baud(Checked):
    """Marks a baud rate."""

    def __init__(self, most: int, choices: tuple[int, ...] = ()) -> None:
        """Set the highest rate, or the few rates that are possible."""
        super().__init__(self.read_baud, type="integer", minimum=300, maximum=most)
        self._most = most
        self._choices = choices

    def read_baud(self, value: Any) -> int:
        """Accept a whole number from 300 to the highest rate, or one of the choices only."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise refuse("a baud rate is a whole number", "Write it without a unit, such as 9600")
        if self._choices and value not in self._choices:
            raise refuse(
                f"{value} baud is not usual on such a line",
                f"Use {listed([str(baud) for baud in self._choices])}",
            )
        if not 300 <= value <= self._most:
            raise refuse(
                f"{value} is no usable baud rate", f"Use 300 to {self._most}, such as 9600"
            )
        return value


class Address(Checked):
    """Marks a name by which a host calls a part: a letter and a digit, or a letter."""

    def __init__(self, pattern: str, what: str, examples: str) -> None:
        """Set the pattern; for messages: the thing that it names, and examples."""
        super().__init__(self.read_address, type="string", pattern=f"^{pattern}$")
        self._pattern, self._what, self._examples = pattern, what, examples

    def read_address(self, value: Any) -> str:
        """Accept a name that matches the pattern."""
        if not isinstance(value, str) or not re.fullmatch(self._pattern, value):
            raise refuse(f"a host has no such name for {self._what}", f"Write {self._examples}")
        return value


LONGEST_COUNTDOWN_S = 359_940.0
"""99 h 59 min: the longest time that the display has room for."""

_Minutes = Annotated[float, Quantity(DURATION, least=60.0, most=LONGEST_COUNTDOWN_S)]


class Countdown(Model):
    """A time, set at the keypad, after which the loop goes off."""

    longest_s: _Minutes = Field(86_400.0, alias="longest", description="Longest time.")
    step_s: _Minutes = Field(
        300.0, alias="step", description="Change of the time for each press of UP or DOWN."
    )
    counts: Literal["from setpoint", "at once"] = Field(
        "from setpoint", description="When the time starts to count."
    )


_LEAST, _MOST = Field(description="Lowest value."), Field(description="Highest value.")
_STEP = Field(description="Change for each press of UP or DOWN.")


class DifferenceRange(Model):
    """Range in which the keypad sets a temperature difference, K."""

    minimum: Annotated[float, Quantity(DIFFERENCE, least=0.0), _LEAST]
    maximum: Annotated[float, Quantity(DIFFERENCE, least=0.0), _MOST]
    step: Annotated[float, Quantity(DIFFERENCE, least=0.01), _STEP]


class DurationRange(Model):
    """Range in which the keypad sets a duration, s."""

    minimum: Annotated[float, Quantity(DURATION, least=0.0), _LEAST]
    maximum: Annotated[float, Quantity(DURATION, least=0.0), _MOST]
    step: Annotated[float, Quantity(DURATION, least=0.01), _STEP]


class GainRange(Model):
    """Range in which the keypad sets a gain, in the gain's unit."""

    minimum: Annotated[float, BareNumber(0.0, LARGEST_GAIN, "0.5", closed=True), _LEAST]
    maximum: Annotated[float, BareNumber(0.0, LARGEST_GAIN, "0.5", closed=True), _MOST]
    step: Annotated[float, BareNumber(0.0, LARGEST_GAIN, "0.5"), _STEP]


class Adjust(Model):
    """Numbers of the loop's algorithm that the operator sets at the keypad."""

    hysteresis: DifferenceRange | None = Field(None, description="For on_off, three_position.")
    lead: DurationRange | None = Field(None, description="For on_off, three_position.")
    kp: GainRange | None = Field(None, description="For pid, %/K.")
    ki: GainRange | None = Field(None, description="For pid, %/(K·s).")
    kd: GainRange | None = Field(None, description="For pid, %·s/K.")


class _OfOneLoop(Model):
    """An interface that shows or sets one loop."""

    kind: str
    loop: Reference | None

    @property
    def named_loops(self) -> dict[Path, str]:
        """Loops by the keys that name them."""
        return {} if self.loop is None else {("loop",): self.loop}


class LcdKeypad(_OfOneLoop):
    """The Arduino LCD keypad shield: 16x2 characters, five keys on A0."""

    kind: Literal["lcd_keypad"]
    loop: Reference = Field(description="Loop that is shown and set.")
    step_k: Annotated[float, Quantity(DIFFERENCE, least=0.1, most=100.0)] = Field(
        1.0, alias="step", description="Change of the setpoint for each press of UP or DOWN."
    )
    countdown: Countdown | None = Field(
        None, description="Let the operator set a time after which the loop goes off."
    )
    adjust: Adjust | None = Field(
        None, description="Numbers of the algorithm that the operator may set. Default: none."
    )
    least: ClassVar[Least] = Least(1080, 60)
    shield: ClassVar[Shield] = LCD_KEYPAD
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = True
    line: ClassVar[None] = None
    named_pins: ClassVar[NamedPins] = ()


class SerialPlotter(_OfOneLoop):
    """One line of numbers each period for the program Serial Port Plotter."""

    kind: Literal["serial_plotter"]
    loop: Reference = Field(description="Loop whose numbers are sent.")
    baud: Annotated[int, Baud(2_000_000)] = Field(9600, description="Speed of the line.")
    decimals: Annotated[int, WholeNumber("a number of decimals", 0, 2, 2)] = Field(
        2, description="Decimals of every number."
    )
    line_end: Literal["LF", "CR LF"] = Field(
        "LF", description="What ends a line; `CR LF` is what Arduino's println sends."
    )
    least: ClassVar[Least] = Least(340, 15)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = False
    named_pins: ClassVar[NamedPins] = ()

    @property
    def line(self) -> Line:
        """The serial line that the interface talks on."""
        return Line(self.baud, USUAL_BAUDS, "serial plotter", receives=False)


class ModbusRtu(Model):
    """A slave on a Modbus serial line; its master sets and switches every loop."""

    kind: Literal["modbus_rtu"]
    address: Annotated[int, WholeNumber("an address", 1, 247, 1)] = Field(
        1, description="Address of this slave, 1 to 247."
    )
    baud: Annotated[int, Baud(115_200, BUS_BAUDS)] = Field(
        19_200, description="Speed of the line: one of the usual ones, 1200 to 115200."
    )
    parity: Literal["even", "odd", "none"] = Field(
        "even", description="Parity of each character; `even` is the standard's default."
    )
    asked_stop_bits: Literal[1, 2] | None = Field(
        None, alias="stop_bits", description="Stop bits. Default: 2 without parity, 1 with it."
    )
    driver_enable: PinName | None = Field(
        None, description="Pin that switches an RS-485 driver to sending; high sends."
    )
    linuxcnc: StrictBool = Field(
        False, description="Generate the LinuxCNC side too: HAL, panel, mb2hal."
    )
    least: ClassVar[Least] = Least(2770, 245)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = True
    acknowledges: ClassVar[bool] = True
    named_loops: ClassVar[Mapping[Path, str]] = {}

    @property
    def line(self) -> Line:
        """The serial line that the interface talks on."""
        line = Line(self.baud, BUS_BAUDS, "Modbus")
        return line._replace(parity=self.parity, stop_bits=self.stop_bits)

    @property
    def named_pins(self) -> NamedPins:
        """The pin of the line's driver."""
        if self.driver_enable is None:
            return ()
        return ((("driver_enable",), self.driver_enable, "the line's driver"),)

    @property
    def stop_bits(self) -> int:
        """Stop bits of each character."""
        return self.asked_stop_bits or (2 if self.parity == "none" else 1)

    @property
    def character_bits(self) -> int:
        """Bits of a character on the line, its start bit included; 11 according to the standard."""
        return 1 + 8 + (self.parity != "none") + self.stop_bits


def _memory(value: Any) -> str:
    if value == "sd":
        raise refuse(
            "a log cannot be kept on an SD card: a card that is pulled or worn would stall the "
            "control, and a file system needs more RAM than the smaller chips have",
            "Use ram or eeprom, and read the log out over the serial port",
        )
    if value not in ("ram", "eeprom"):
        word = shown(value) if isinstance(value, str) else "this"
        raise refuse(f"{word} is not possible", "Use ram or eeprom")
    return str(value)


Meaning = Literal["enabled", "heating", "cooling", "warm", "communicating", "fault"]


class Indicators(_OfOneLoop):
    """LEDs that show a loop's state: on, blinking or off."""

    kind: Literal["indicators"]
    loop: Reference | None = Field(
        None, description="Loop that is shown; needed where there are several."
    )
    leds: Annotated[Mapping[PinName, Meaning], Filled] = Field(
        description="What each pin's LED shows."
    )
    active: Literal["high", "low"] = Field("high", description="Level at which an LED lights.")
    least: ClassVar[Least] = Least(50, 0)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = False
    line: ClassVar[None] = None

    @property
    def named_pins(self) -> NamedPins:
        """The pins of its LEDs."""
        return tuple((("leds", pin), pin, f"the LED {told}") for pin, told in self.leds.items())


_Port = Annotated[int, WholeNumber("a serial port", 0, 3, 0)]
_PORT = "Serial port of the board, by its number."


class Nextion(_OfOneLoop):
    """A Nextion touch display on a serial port."""

    kind: Literal["nextion"]
    loop: Reference = Field(description="Loop that is shown and set.")
    baud: Annotated[int, Baud(115_200, DISPLAY_BAUDS)] = Field(
        115_200, description="Speed of the line; the firmware sets the display to it."
    )
    port: _Port = Field(0, description=_PORT)
    least: ClassVar[Least] = Least(5300, 1460)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = True
    named_pins: ClassVar[NamedPins] = ()

    @property
    def line(self) -> Line:
        """The serial line that the interface talks on."""
        return Line(self.baud, DISPLAY_BAUDS, None, port=self.port, can_move=True)


class SerialLog(_OfOneLoop):
    """Temperature and setpoint in a ring buffer, read out over a serial port."""

    kind: Literal["serial_log"]
    loop: Reference = Field(description="Loop that is logged.")
    baud: Annotated[int, Baud(FASTEST_HOST)] = Field(115_200, description="Speed of the line.")
    port: _Port = Field(0, description=_PORT)
    every_s: Annotated[float, Quantity(DURATION, least=1.0, most=3600.0)] = Field(
        60.0, alias="every", description="Time between entries."
    )
    entries: Annotated[int, WholeNumber("a number of entries", 1, 1000, 480)] = Field(
        480, description="Entries of the ring buffer; a new entry replaces the oldest."
    )
    keep: Annotated[Literal["ram", "eeprom"], Checked(_memory, enum=["ram", "eeprom"])] = Field(
        "ram", description="Where the ring buffer is; `eeprom` survives a loss of power."
    )
    least: ClassVar[Least] = Least(1800, 70)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = False
    acknowledges: ClassVar[bool] = False
    named_pins: ClassVar[NamedPins] = ()

    @property
    def line(self) -> Line:
        """The serial line that the interface talks on."""
        return Line(self.baud, HOST_BAUDS, "serial log", port=self.port, can_move=True)


class Gcode(Model):
    """A host program of 3D printers, or a person, over the serial line."""

    kind: Literal["gcode"]
    baud: Annotated[int, Baud(FASTEST_HOST)] = Field(115_200, description="Speed of the line.")
    loops: Annotated[
        Mapping[
            Annotated[
                str, Address("(T[0-9]|B|C)", "a loop", "T0 to T9, B (the bed) or C (the chamber)")
            ],
            Reference,
        ],
        Filled,
    ] = Field(description="Loops by what the host calls them: T0 to T9, B the bed, C the chamber.")
    fans: Annotated[
        Mapping[Annotated[str, Address("P[0-9]", "a fan", "P0 to P9")], Reference], ReadOnly
    ] = Field({}, description="Fans by what the host calls them, P0 to P9.", validate_default=True)
    steppers: Annotated[
        Mapping[Annotated[str, Address("E", "a stepper", "E")], Reference], ReadOnly
    ] = Field({}, description="The stepper that feeds, E.", validate_default=True)
    least: ClassVar[Least] = Least(6050, 480)
    shield: ClassVar[None] = None
    is_host: ClassVar[bool] = True
    acknowledges: ClassVar[bool] = True
    named_pins: ClassVar[NamedPins] = ()

    @property
    def line(self) -> Line:
        """The serial line that the interface talks on."""
        return Line(self.baud, HOST_BAUDS, "G-code")

    @property
    def named_loops(self) -> dict[Path, str]:
        """Loops by the keys that name them."""
        return {("loops", address): name for address, name in self.loops.items()}


Interface = Annotated[
    Gcode | Indicators | LcdKeypad | ModbusRtu | Nextion | SerialLog | SerialPlotter,
    Field(discriminator="kind"),
]
if not TYPE_CHECKING:  # mypy knows only heatwright's own kinds
    Interface = with_brought("interface", Interface)
