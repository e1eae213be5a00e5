"""The ADC: one scan per tick, shared by the analog sensors and the keypad."""

import math
from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.parts import Call, Constant, Part, Stage, pair
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, facts_of
from heatwright.spec.sensing.circuits import reference_v

FASTEST_HZ = 200_000
"""Fastest ADC clock for the full ten bits (data sheets, "Prescaling and conversion timing")."""

FAR = 8
"""First channel that needs the bit MUX5, which is in ADCSRB (ATmega2560, 32U4)."""

CODES = 1024
WRONG_TICKS = 100
"""Ticks in a row with a wrong code after which the rule adc_wrong trips."""
KNOWN_TOLERANCE = 0.25
"""Tolerance of the expected code, as a share: that of the band gap plus that of the reference, a
supply of 4.5 to 5.5 V."""

REFERENCES = {
    "supply": ("(1u << REFS0)", "The supply, AVCC."),
    "internal": ("(1u << REFS1) | (1u << REFS0)", "The chip's internal reference."),
    "external": ("0", "The voltage at the pin AREF."),
}
"""Bits of ADMUX and their meaning; the same on all chips."""


def channel_macro(sensor: str) -> str:
    """The C name of a sensor's channel."""
    return f"ADC_SENSOR_{sensor.upper()}"


@dataclass(frozen=True, slots=True)
class AdcNames:
    """The values for the templates of a sensor on the ADC."""

    pin: str
    circuit: str
    channel: str
    oversample: int


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel that the scan converts once."""

    macro: str
    name: str
    where: str
    mux: str
    far: str = "0"


@dataclass(frozen=True, slots=True)
class KnownVoltage:
    """The chip's internal voltage, and the limits of its code."""

    name: str
    where: str
    mux: str
    low: int
    high: int


@dataclass(frozen=True, slots=True)
class ScanNames:
    """The values for the templates of the scan.

    interrupts -- the scan also has sensors, so interrupts make it; far -- a channel needs the bit
    MUX5; mixed -- only some channels need it; enabled -- C of ADCSRA; reference -- C of ADMUX.
    """

    channels: list[Channel]
    interrupts: bool
    far: bool
    mixed: bool
    has_mux5: bool
    known: KnownVoltage | None
    enabled: str
    clock_khz: str
    reference: str
    reference_is: str
    digital_inputs_off: list[str]


def scan(root: Source) -> Part:
    """Plan the scan: the same part for each component that uses it, so it is printed once."""
    controller = root.controller
    board = controller.board
    channels = _channels(root)
    fars = [channel.far != "0" for channel in channels]
    code = next(code for code in range(1, 8) if board.clock_hz / (1 << code) <= FASTEST_HZ)
    reference, reference_is = REFERENCES[_reference(controller)]
    context = ScanNames(
        channels=channels,
        interrupts=has_sensors(controller),
        far=any(fars),
        mixed=len(set(fars)) > 1,
        has_mux5=board.adc.has_mux5,
        known=_known(root),
        enabled="(1u << ADEN)" + _bits("ADPS", code),
        clock_khz=f"{board.clock_hz / (1 << code) / 1000:g}",
        reference=reference,
        reference_is=reference_is,
        digital_inputs_off=_digital_inputs_off(controller),
    )
    return Part(
        files=pair("adc", "peripherals/adc", context),
        start_calls=(Call(Stage.OPERATE, "adc.h", "adc_start();"),),
        tick_calls=(Call(Stage.CONTROL, "adc.h", "adc_tick();"),),
    )


def known_limits(root: Source) -> tuple[Constant, ...]:
    """The limits for the code of the chip's internal voltage; none if it is not measured."""
    known = _known(root)
    if known is None:
        return ()
    told = f"{known.where}: {known.name}"
    wrong = quantity(TICK_MS * WRONG_TICKS / 1000, "s")
    return (
        Constant("ADC_KNOWN_LOW", f"{known.low}u", f"{told}, 25 % less"),
        Constant("ADC_KNOWN_HIGH", f"{known.high}u", f"{told}, 25 % more"),
        Constant("ADC_WRONG_TICKS", f"{WRONG_TICKS}u", f"{known.where}: {wrong}"),
    )


def has_sensors(controller: Controller) -> bool:
    """Return whether a sensor is on the ADC, and not only the keypad."""
    return bool(controller.adc_sensors)


def channel_of(controller: Controller, pin: str) -> int:
    """The ADC's channel on a pin."""
    channel = controller.board.pins[pin].adc
    assert channel is not None  # noqa: S101 - the spec refuses pins without one
    return channel


def _channels(root: Source) -> list[Channel]:
    """List the sensors in the spec's order, then the keypad; a known voltage is first and last."""
    controller = root.controller
    channels = [
        _channel(controller, channel_macro(name), sensor.pin, root.at("sensors", name, "pin"))
        for name, sensor in controller.adc_sensors.items()
    ]
    channels += [
        _channel(controller, "ADC_KEYPAD", interface.shield.keys, root.at("interfaces", index))
        for index, interface in enumerate(controller.interfaces)
        if interface.shield is not None
    ]
    known = _known(root)
    if known is None:
        return channels
    first, last = (
        Channel(macro, known.name, known.where, known.mux)
        for macro in ("ADC_KNOWN", "ADC_KNOWN_IS_NEXT")
    )
    return [first, *channels, last]  # its weak source then has a whole tick to settle


def _known(root: Source) -> KnownVoltage | None:
    """The chip's internal voltage, which the self-checks measure in addition to the sensors."""
    board = root.controller.board
    if not facts_of(root.controller).measures_known_voltage:
        return None
    first = next(iter(root.controller.adc_sensors.values()))
    code, known_v = board.adc.band_gap_code, board.adc.band_gap_v
    share = known_v / reference_v(first, board.mcu)
    return KnownVoltage(
        name=f"the chip's internal {known_v} V",
        where=root.at("safety", "self_checks").where,
        mux=_bits("MUX", code),
        low=math.floor(CODES * share * (1 - KNOWN_TOLERANCE)),
        high=min(CODES - 1, math.ceil(CODES * share * (1 + KNOWN_TOLERANCE))),
    )


def _channel(controller: Controller, macro: str, pin: str, source: Source) -> Channel:
    number = channel_of(controller, pin)
    far = "(1u << MUX5)" if number >= FAR else "0"
    return Channel(macro, f"ADC{number}", source.where, _bits("MUX", number % FAR), far)


def _bits(name: str, code: int) -> str:
    """C text that adds the bits of `code` to a register's value, such as ` | (1u << MUX0)`."""
    return "".join(f" | (1u << {name}{bit})" for bit in (4, 3, 2, 1, 0) if code & (1 << bit))


def _reference(controller: Controller) -> str:
    """The reference of all channels, which the spec keeps equal; the keypad needs the supply."""
    for sensor in controller.adc_sensors.values():
        return sensor.reference if isinstance(sensor.reference, str) else "external"
    return "supply"


def _digital_inputs_off(controller: Controller) -> list[str]:
    """C that switches off the digital inputs at sensors: at half the supply they draw current."""
    board = controller.board
    if board.is_old:
        return []
    numbers = [channel_of(controller, each.pin) for each in controller.adc_sensors.values()]
    lines = []
    for register, group in (("DIDR0", range(FAR)), ("DIDR2", range(FAR, 16))):
        able = [n for n in numbers if n in group and n in board.adc.digital_inputs]
        bits = " | ".join(f"(1u << ADC{number}D)" for number in sorted(able))
        lines += [f"{register} = {bits}; /* no digital inputs there */"] if bits else []
    return lines
