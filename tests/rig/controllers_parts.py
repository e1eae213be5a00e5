"""What a drawn controller is made of: numbers, pins and timers of its board, sensors, PWM."""

import math
from collections.abc import Callable, Collection
from random import Random
from typing import Any

from pydantic import TypeAdapter

from heatwright.spec import Board, Pin, Sensor, Thermistor, Timer
from heatwright.spec.board.pwm_timers import FASTEST_BY_INTERRUPTS_HZ, FEWEST_COUNTS, pwm_settings
from heatwright.spec.board.timers import tick_interval
from heatwright.spec.sensing.analog_parts import AnalogSensor
from heatwright.spec.sensing.circuits import SUPPLY_V, reference_v
from heatwright.spec.sensing.max31856 import AVERAGES, RANGE_C, Max31856
from heatwright.spec.sensing.thermocouples import MAX31855_RANGE_C

Part = dict[str, Any]
_SENSOR: TypeAdapter[Any] = TypeAdapter(Sensor)
NARROWEST_K = 45.0
"""Range of a sensor, without what its errors take off at both ends: room for a machine."""
LEAST_TOP_C = 50.0
"""Top of a drawn range, where the circuit shows that: a room, and what a machine needs."""
BY_INTERRUPTS_HZ = 6_000_000
"""Clock for each loop with which a tick is mostly short enough for a PWM by interrupts."""


def text(value: float, unit: str = "") -> str:
    return f"{value:.10g} {unit}".rstrip()


def tidy(value: float, digits: int = 3) -> float:
    return float(f"{value:.{digits}g}")


class Unsuited(Exception):
    """What was drawn so far cannot become a controller."""


class Draws:
    """Draws, the simplest first: what fails shrinks to the plainest of its kind."""

    def __init__(self, between: Callable[[int, int], int], seldom: int = 6) -> None:
        self._between = between  # draws a whole number from one to another
        self._seldom = seldom

    def one(self, *choices: Any) -> Any:
        if not choices:
            raise Unsuited
        return choices[self._between(0, len(choices) - 1)]

    def some(self) -> bool:
        return bool(self._between(0, 1))

    def maybe(self, part: Part) -> Part:
        return part if self.some() else {}

    def seldom(self) -> bool:
        return self._between(1, self._seldom) == self._seldom

    def number(self, low: float, high: float, usual: float, step: float = 1.0) -> float:
        """Draw a multiple of the step: the usual one, an end, or any between."""
        first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
        last = max(first, last)
        plain = min(max(round(usual / step), first), last)
        way = self.one("plain", "first", "last", "between", "between")
        ends = {"plain": plain, "first": first, "last": last}
        return round(ends.get(way, self._between(first, last)) * step, 9)


def own_draws(part: Part) -> Draws:
    """Give draws that follow from what was drawn of a part, and use up no random number. For what
    shapes no machine: the machines that a seed gives stay as they are."""
    return Draws(Random(repr(part)).randint)  # noqa: S311 - no secret


NUMBERS = (
    ("hysteresis", "K", 2, 4), ("lead", "s", 2, 9), ("kp", "", 4, 9), ("ki", "", 4, 8),
    ("kd", "", 4, 8),
)  # fmt: skip
"""Keys, units, decimals and columns of what an LCD's keys may set."""


def adjusted(draws: Draws, algorithm: Part) -> Part:
    """Let keys set some of an algorithm's numbers, from a little below what they are up to that."""
    part: Part = {}
    for key, unit, most, room in NUMBERS:
        value = float(str(algorithm.get(key, 0)).split()[0])
        decimals = next((n for n in range(most + 1) if round(value, n) == value), most + 1)
        low = round(draws.one(0.95, 0.9, 0.99) * value, min(decimals + 1, most))
        decimals = next((n for n in range(most + 1) if round(low, n) == low), decimals)
        fits = decimals <= most and len(f"{value:.{max(decimals, 1)}f}") <= room
        if not fits or low >= value or draws.one(False, False, True):
            continue
        step = round(value - low, 4)
        ends = {"minimum": low, "maximum": value, "step": step}
        part[key] = {end: text(each, unit) if unit else each for end, each in ends.items()}
    return part


class Resources:
    """The pins and timers of a board that are left."""

    def __init__(self, draws: Draws, board: Board, loops: int) -> None:
        self.draws, self.board, self._loops = draws, board, loops
        barred = () if board.bootloader_bytes else board.jtag_pins
        pins = {pin.name: pin for pin in board.pins.values() if pin.port_name not in barred}
        self._free = sorted(pins.values(), key=lambda pin: (pin.adc is not None, pin.digital))
        self.kept_analog = 0  # pins of the ADC that somebody will need
        self.timers = dict(board.timers)  # that nobody has
        self._shared: dict[int, float] = {}  # frequency of timers that make PWM at their pins, Hz

    @property
    def pins(self) -> int:
        """How many pins are left that can be switched."""
        return sum(pin.digital for pin in self._free)

    def keep_off(self, names: Collection[str]) -> None:
        """Take pins that have a purpose by themselves."""
        taken = {self.board.pins[name] for name in names}
        self._free = [pin for pin in self._free if pin not in taken]

    def _take(self, fitting: list[Pin]) -> str:
        pin = self.draws.one(*fitting)
        self._free.remove(pin)
        return str(self.draws.one(pin.name, pin.port_name) if pin.digital else pin.name)

    def analog(self) -> str:
        return self._take([pin for pin in self._free if pin.adc is not None])

    def has_analog(self) -> bool:
        return sum(pin.adc is not None for pin in self._free) > self.kept_analog

    def digital(self, *, heats: bool = False) -> str:
        """Take a pin that can be switched; for a heater one that nothing drives before."""
        return self._take([pin for pin in self._switched() if not heats or self._is_quiet(pin)])

    def _switched(self) -> list[Pin]:
        found = [pin for pin in self._free if pin.digital]
        spare = self.has_analog()
        return [pin for pin in found if spare or pin.adc is None] or found

    def _is_quiet(self, pin: Pin) -> bool:
        programmed = not self.board.bootloader_bytes and pin.spi in {"sck", "mosi"}
        return not pin.bootloader and not programmed

    def take_timer(self) -> bool:
        """Take any timer, if one is left beside that of the tick."""
        left = sorted(self.timers, key=lambda number: (self.timers[number].bits, number))
        return self._leaves_tick(left[:1]) and self.timers.pop(left[0], None) is not None

    def _leaves_tick(self, taken: list[int]) -> bool:
        left = [timer for number, timer in self.timers.items() if number not in taken]
        ticking = [timer for timer in left if tick_interval(self.board.clock_hz, timer)]
        return bool(taken) and bool(ticking)

    def pwm(self, slowest_hz: float, *, heats: bool) -> Part | None:
        """Take a pin and what makes PWM on it, if the board has that left."""
        pins = [pin for pin in self._switched() if self._is_quiet(pin) or not heats]
        able = [pin for pin in pins if pin.pwm and self._serves(pin.pwm[0], slowest_hz)]
        free = [number for number, timer in self.timers.items() if timer.bits == 16]
        soon = self.board.clock_hz >= BY_INTERRUPTS_HZ * self._loops
        by_interrupts = [n for n in free if self._leaves_tick([n])] if soon else []
        ways = ["timer"] * bool(able) + ["interrupts"] * bool(by_interrupts)
        if not ways:
            return None
        if self.draws.one(*ways) == "timer":
            return self._by_timer(able, slowest_hz)
        slow_hz = self.draws.number(max(slowest_hz, 2), FASTEST_BY_INTERRUPTS_HZ, 100)
        del self.timers[max(by_interrupts)]
        plain = [pin for pin in pins if pin.pwm is None] or pins
        return {"pin": self._take(plain), "frequency": text(slow_hz, "Hz")}

    def _serves(self, number: int, slowest_hz: float) -> bool:
        if number in self._shared:
            return self._shared[number] >= slowest_hz
        return number in self.timers and self._leaves_tick([number])

    def _by_timer(self, able: list[Pin], slowest_hz: float) -> Part:
        pin = self.draws.one(*able)
        number = pin.pwm[0]
        if number not in self._shared:
            timer = self.timers.pop(number)
            made_hz = _frequency(self.draws, self.board.clock_hz, timer, max(slowest_hz, 1.0))
            self._shared[number] = made_hz
        self._free.remove(pin)
        return {"pin": pin.name, "frequency": text(self._shared[number], "Hz")}


def _frequency(draws: Draws, clock_hz: int, timer: Timer, slowest_hz: float) -> float:
    """Draw what a timer can make, Hz."""
    if timer.bits == 8:
        made_hz = [each.frequency_hz for each in pwm_settings(clock_hz, timer)]
        return float(draws.one(*[each for each in made_hz if each >= slowest_hz][::-1]))
    return draws.number(slowest_hz, clock_hz / FEWEST_COUNTS, 100)


THERMISTORS: tuple[Part, ...] = (
    {"resistance": "100 kΩ", "at": "25 °C", "beta": "3950 K"},
    {"a": 8.11e-4, "b": 2.115e-4, "c": 7.07e-8},
    {"points": [["-20 °C", "940 kΩ"], ["25 °C", "100 kΩ"], ["100 °C", "6.7 kΩ"],
                ["180 °C", "960 Ω"], ["300 °C", "150 Ω"]]},
    {"codes": [[16, "420 °C"], [528, "285 °C"], [1100, "235 °C"], [4000, "165 °C"],
               [10000, "108 °C"], [14000, "65 °C"], [15600, "25 °C"], [16200, "-25 °C"]],
     "readings": 16},
)  # fmt: skip


class Sensors:
    def __init__(self, left: Resources, reference: str) -> None:
        self.draws, self.board, self.left = left.draws, left.board, left
        self.reference = reference  # of the ADC: one for all

    def draw(self, spare_pins: int, *, chosen: bool, cold: bool) -> tuple[Part, Any]:
        """Draw one with no more than these pins; return its part of the file and its model. An
        operator may choose its type (`chosen`); it measures what a room has (`cold`)."""
        kinds = ["analog", "thermistor", "rtd"] * self.left.has_analog()
        kinds += ["max6675", "max31855"] * (spare_pins >= 3)
        kinds += ["max31856"] * (1 + 5 * chosen) * (spare_pins >= 4)
        if len(self.left.timers) > 1:
            kinds.insert(0, "ds18b20")
        kind = self.draws.one(*(kinds or ["ds18b20"]))
        if kind == "ds18b20" and not self.left.take_timer():
            kind = "analog"
        part = {"kind": kind, **getattr(self, f"_{kind}")(chosen, cold)}
        average = self.draws.number(1, 16, 1)
        if average > 1:
            part["moving_average"] = int(average)
        return part, _SENSOR.validate_python(part)

    def _ds18b20(self, *_: bool) -> Part:
        bits = self.draws.one(12, 9, 10, 11)
        return {"pin": self.left.digital()} | ({"resolution": f"{bits} bit"} if bits < 12 else {})

    def _wires(self, *names: str) -> Part:
        return {name: self.left.digital() for name in names}

    def _max6675(self, *_: bool) -> Part:
        return self._wires("chip_select", "clock", "data_out")

    def _max31855(self, *_: bool) -> Part:
        kind = self.draws.one(*MAX31855_RANGE_C)
        return self._wires("chip_select", "clock", "data_out") | {"thermocouple": kind}

    def _max31856(self, chosen: bool, cold: bool) -> Part:
        kinds = [kind for kind in ("K", *RANGE_C) if RANGE_C[kind][0] < 0 or not cold]
        part = self._wires("chip_select", "clock", "data_in", "data_out")
        part["thermocouple"] = kind = self.draws.one(*kinds)
        others = [other for other in kinds if other not in {kind, "B"}]
        if chosen and kind != "B":
            part |= self.draws.maybe({"selectable": [self.draws.one(*others), kind]})
        if self.draws.some():
            part["mains_filter"] = "60 Hz"
        return part | {"average": self.draws.one(*AVERAGES)}

    def _on_adc(self, part: Part) -> Part:
        part = {"pin": self.left.analog(), **part}
        if self.reference != "supply":
            part["reference"] = self.reference
        oversample = self.draws.number(1, 32, 4)
        return part | {"oversample": int(oversample)}

    def _thermistor(self, *_: bool) -> Part:
        divider = self._divider("4.7 kΩ", "1 kΩ", "47 kΩ")
        curves = THERMISTORS[: -1 if self.reference == "internal" else None]
        part = {"divider": divider, "curve": self.draws.one(*curves)}
        return self._ranged("thermistor", part, -20.0, 300.0)

    def _rtd(self, *_: bool) -> Part:
        element = self.draws.one("pt1000", "pt100")
        if element == "pt1000" and self.draws.some():
            part = {"divider": self._divider("1 kΩ", "2.2 kΩ")}
        else:
            series = {"pt1000": "10 kΩ", "pt100": "1 kΩ"}[element]
            excitation = text(self._full_v(), "V")
            part = {"amplifier": {"gain": 10, "excitation": excitation, "series": series}}
        part = {"element": element} | self.draws.maybe({"alpha": "3925 ppm/K"}) | part
        if "amplifier" in part and own_draws(part).some():
            part["amplifier"]["feed"] = "resistors"
        return self._ranged("rtd", part, -190.0, 840.0)

    def _divider(self, *resistors: str) -> Part:
        divider = {self.draws.one("pull_up", "pull_down"): self.draws.one(*resistors)}
        if self.reference != "supply":
            divider["supply"] = text(self._full_v(), "V")
        return divider

    def _full_v(self) -> float:
        told: Any = {"3 V": 3.0}.get(self.reference, self.reference)
        return reference_v(Thermistor.model_construct(reference=told), self.board.mcu)

    def _analog(self, *_: bool) -> Part:
        span_k = self.draws.one(100, 50, 400)
        share = self._full_v() / SUPPLY_V
        scale_mv = tidy(share * 4500 / (span_k + 60))
        falls = self.draws.some()
        offset_v = tidy(share * 4.5 - 0.05 if falls else 50 * scale_mv / 1000)
        part = {"scale": text(-scale_mv if falls else scale_mv, "mV/K")}
        part["offset"] = text(offset_v, "V")
        part |= self.draws.maybe({"open_reads": "high"})
        return self._ranged("analog", part, -45.0, 450.0)

    def _ranged(self, kind: str, part: Part, low_c: float, high_c: float) -> Part:
        """Add a range that the circuit shows; where it shows too little, take a plain one."""
        part = self._on_adc(part)
        whole = {"kind": kind, **part, "range": f"{low_c} °C .. {high_c} °C"}
        chain = _SENSOR.validate_python(whole).circuit(self.board.mcu)
        ends = chain.celsius(0.006), chain.celsius(min(chain.highest, 1.0) - 0.006)
        low_c, high_c = max(min(ends), low_c), min(max(ends), high_c)
        if high_c - low_c < NARROWEST_K + 2 or low_c > 10:
            low_c, high_c = max(low_c, -45.0), max(high_c, 60.0)
        first = self.draws.number(math.ceil(low_c), min(10, high_c - NARROWEST_K), 0)
        warm_c = max(first + NARROWEST_K, min(LEAST_TOP_C, math.floor(high_c)))
        last = self.draws.number(warm_c, math.floor(high_c), high_c)
        part |= {"range": f"{text(first)} °C .. {text(last)} °C"}
        draws = own_draws(part)
        part |= draws.maybe({"tolerances": self._tolerances(draws, kind, part)})
        within = text(draws.number(0.1, 50, 1, 0.1), "K")
        return part | draws.maybe({"accuracy": {"within": within}})

    @staticmethod
    def _tolerances(draws: Draws, kind: str, part: Part) -> Part:
        """Say how exact some or all parts of a chain are."""
        percent = text(draws.number(0, 5, 1, 0.01), "%")
        off = text(draws.number(0, 100, 6), "mV")
        told: Part = draws.maybe({"reference": off}) | draws.maybe({"adc": draws.number(0, 5, 2)})
        if kind == "analog":
            return told | {"scale": percent} | draws.maybe({"offset": off})
        element = draws.one("A", "AA", "B", "C") if kind == "rtd" else percent
        told |= {"element": element} | draws.maybe({"resistors": percent})
        if "beta" in part.get("curve", {}):
            told |= draws.maybe({"beta": percent})
        if "amplifier" in part or "supply" in part["divider"] or "reference" in part:
            told |= draws.maybe({"supply": draws.one(off, "reference")})
        return told


def usable_c(sensor: Any, *, hottest_own: bool = False) -> tuple[float, float]:
    """Give the lowest and the highest temperature that a sensor surely shows, of all its types.

    hottest_own -- the highest is that of the type it begins with.
    """
    kinds = [sensor]
    if isinstance(sensor, Max31856) and sensor.selectable:
        kinds = [sensor.model_copy(update={"thermocouple": each}) for each in sensor.selectable]
    lows, highs = zip(*(each.range_c for each in kinds), strict=True)
    errors_k = max(each.error_k(end) for each in kinds for end in each.range_c)
    high_c = sensor.highest_c if hottest_own else min(highs)
    return max(lows) + errors_k, high_c - errors_k


def step_k(sensor: Any, mcu: str, low_c: float, high_c: float) -> float:
    if not isinstance(sensor, AnalogSensor):
        return float(sensor.step_k)
    places = [low_c + share * (high_c - low_c) / 8 for share in range(9)]
    return max(sensor.step_at_k(place, mcu) for place in places)
