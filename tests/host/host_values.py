"""Numbers of a host build: a sensor's codes, texts, limits that may be, and types of thermocouples.
Between temperatures and codes there are scales, for courses that go to a temperature. A loop goes
by limits that may be, whatever its settings have become; the chosen type of thermocouple lowers
what may be asked for (docs/language.md)."""

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import ROUND_HALF_UP, Decimal
from fractions import Fraction
from functools import cache
from importlib import import_module
from itertools import product
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.host import Host
from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference.algorithms.pid import limits_of, may_limit
from heatwright.sim.reference.inputs import Limits
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Controller, Pid
from heatwright.spec.registry import module_of
from heatwright.spec.sensing.max31856 import TYPE_CODES, lowered

ADC_CODES = 1024


@dataclass(frozen=True)
class Steps:
    """Codes that are whole numbers of a part of a kelvin."""

    per_k: int
    lowest: int
    highest: int  # codes that may come; those of `noise` are where the sensor mostly is
    noise: tuple[int, int]
    first = 0

    def celsius(self, code: int) -> float:
        return code / self.per_k

    def code(self, celsius: float) -> int:
        return round(celsius * self.per_k)

    def moved(self, code: int, by_k: float) -> int:
        """Return the code farthest from another that is no more than `by_k` from it."""
        return code + int(by_k * self.per_k)


_QUARTERS = Steps(4, 0, 4095, (0, 4095))
_STEPS = {
    "ds18b20": Steps(16, -(2**15), 2**15 - 1, (-55 * 16, 125 * 16)),
    "max31856": Steps(128, -(2**18), 2**18 - 1, (-200 * 128, 1372 * 128)),
    "max6675": _QUARTERS,
    "max31855": _QUARTERS,  # from 0 °C on
}


class Table:
    """A sum of codes of the ADC, made a temperature by the reference's table."""

    def __init__(self, controller: Controller, name: str) -> None:
        sensor = controller.sensors[name]
        convert = import_module(module_of("sensor", "reference", sensor.kind)).converter(
            sensor, controller.board
        )
        self.lowest, self.highest = 0, (ADC_CODES - 1) * sensor.oversample
        self._celsius = np.array([float(convert(raw)) for raw in range(self.highest + 1)])
        self._falls = bool(self._celsius[0] > self._celsius[-1])
        self._rising = self._celsius[::-1] if self._falls else self._celsius
        low, high = sorted(self.code(each) for each in sensor.range_c)
        self.noise = (low, high)
        self.first = self.code(20.0)

    def celsius(self, code: int) -> float:
        return float(self._celsius[min(max(code, 0), self.highest)])

    def code(self, celsius: float) -> int:
        place = int(np.searchsorted(self._rising, celsius))
        near = [max(0, place - 1), min(place, self.highest)]
        best = min(near, key=lambda each: abs(self._rising[each] - celsius))
        return self.highest - best if self._falls else best

    def moved(self, code: int, by_k: float) -> int:
        wanted_c = self.celsius(code) + by_k
        if by_k > 0:
            best = int(np.searchsorted(self._rising, wanted_c, "right")) - 1
        else:
            best = int(np.searchsorted(self._rising, wanted_c, "left"))
        best = min(max(best, 0), self.highest)
        return self.highest - best if self._falls else best


@cache
def scale_of(controller: Controller) -> Steps | Table:
    ((_, loop),) = controller.loops.items()
    kind = controller.sensors[loop.sensor].kind
    return _STEPS[kind] if kind in _STEPS else Table(controller, loop.sensor)


LARGEST = 20_000_000
MOST_DECIMALS = 2
HALF_ULP = Fraction(1, 2**24)  # relative error of one operation in single precision

EXTREMES = [
    float(np.float32(value))
    for value in (
        0.0, -0.0, 0.004, -0.004, 0.005, 0.05, 0.5, 0.49999997, 1e-45, -1e-45, 1.1754942e-38, 0.995,
        9.995, 99.5, 99.995, -0.5, -99.995, 65535.5, 8388607.5, 8388609.0, 16777215.0, 16777217.0,
        19999998.0, 2e7, -2e7, 20000002.0, 4.3e9, -4.3e9, 3.4028235e38, -3.4028235e38,
        float("inf"), float("-inf"), float("nan"),
    )
]  # fmt: skip


def text_problem(host: Host, value: float, decimals: int) -> str:
    try:
        text = host.number(value, decimals)
    except ValueError as problem:
        return str(problem)
    if not text.strip("-."):
        return f"{value!r} with {decimals} decimals is {text!r}"
    number = int(text.replace(".", ""))
    exact = LARGEST if not abs(value) < LARGEST else Fraction(abs(value))
    scaled = exact * 10**decimals
    # One rounding for each factor of ten and one for the half that is added.
    slack = Fraction(1, 2) + (decimals + 1) * HALF_ULP * (scaled + 1)
    sign = "-" if value < 0 and number else ""
    whole, part = divmod(abs(number), 10**decimals)
    form = f"{sign}{whole}" + (f".{part:0{decimals}d}" if decimals else "")
    if text != form or abs(abs(number) - scaled) > slack:
        return f"{value!r} with {decimals} decimals is {text}"
    return ""


def code_problem(host: Host, raw: int, decimals: int) -> str:
    """The same for a sensor's code, of which every operation is exact."""
    value = Decimal(raw) / 16
    wanted = f"{value.quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP):f}"
    if Decimal(wanted) == 0:
        wanted = wanted.removeprefix("-")
    try:
        text = host.number(raw / 16, decimals)
    except ValueError as problem:
        return str(problem)
    return "" if text == wanted else f"{value} is {text}, not {wanted}"


def all_text_problems(host: Host) -> str:
    """Say what is wrong with any of many numbers; nothing is, where no text is made."""
    if "text.c" not in host.build.objects:
        return ""
    decimals = range(MOST_DECIMALS + 1)
    problems = [text_problem(host, value, each) for value in EXTREMES for each in decimals]
    problems += [code_problem(host, raw, each) for raw in range(-880, 2001, 7) for each in decimals]
    return "; ".join(filter(None, problems))


MILD_C = 30.0
LEAST_RANGE = 1.0  # least range of the output, above its minimum


def begun_at(host: Host, celsius: float) -> NDArray[Any]:
    """Begin anew; return the inputs of a step that reads this temperature."""
    inputs = np.zeros(1, INPUT)
    inputs["reading_raw"] = scale_of(host.build.controller).code(celsius)
    host.renew()
    return inputs


def next_step(host: Host, inputs: NDArray[Any]) -> Any:
    host.library.fault.code, host.library.fault_complement = 0, 255
    return host.run(inputs).states[0]


def limits_problem(host: Host) -> str:
    """Say which settings the next step does not take, or takes although they cannot be."""
    ((name, loop),) = host.build.controller.loops.items()
    algorithm, library = loop.algorithm, host.library
    if not isinstance(algorithm, Pid) or not algorithm.limits_adjustable:
        return ""
    inputs = begun_at(host, MILD_C)
    for limits in doubtful_limits(algorithm):
        sound = may_limit(algorithm, limits)
        if getattr(library, f"settings_may_limit_{name}")(*limits) != sound:
            return f"{limits}: they {'may' if sound else 'may not'} be"
        for member, limit in zip(Limits._fields, limits, strict=True):
            setattr(library.settings, f"{name}_{member}_percent", limit)
        row = next_step(host, inputs)
        wanted = limits if sound else limits_of(algorithm)
        found = Limits(*(row[f"{member}_percent"] for member in Limits._fields))
        kept = [getattr(library.settings, f"{name}_{each}_percent") for each in Limits._fields]
        if not found == Limits(*map(Single, kept)) == wanted:
            return f"{limits} become {found}, and in the settings {kept}"
    return ""


def doubtful_limits(algorithm: Pid) -> Iterator[Limits]:
    """Limits at each bound and just beside it, in any order, and what is no number."""
    least, most, full = limits_of(algorithm)
    floor = Single(algorithm.output.minimum_percent + LEAST_RANGE)
    middle = Single((least + most) / 2)
    places = (
        (*_about(least), middle, *_about(most), nan, -inf),
        (*_about(least), middle, *_about(most), nan, inf),
        (*_about(floor), *_about(least), middle, *_about(full), nan, inf),
    )
    for limits in product(*places):
        yield Limits(*map(Single, limits))


def _about(bound: Single) -> tuple[Single, ...]:
    return np.nextafter(bound, Single(-200)), bound, np.nextafter(bound, Single(200))


DAMAGED = 0xFF  # a code that nobody can choose: as the type that bears the least


def types_problem(host: Host) -> str:
    controller, parts = host.build.controller, host.build.parts
    loop = controller.loops[parts.name]
    setpoint_c, maximum_c = loop.setpoint.maximum_c, loop.protection.maximum_c
    less = lowered(controller.sensors[parts.sensor], setpoint_c, maximum_c)
    if not less:
        return ""
    types = controller.thermometers[parts.sensor].selectable
    borne = {TYPE_CODES.index(kind): less.get(kind, setpoint_c) for kind in types}
    borne[DAMAGED] = min(less.values())
    above_k = maximum_c - setpoint_c
    checks = [_Chosen(host, code, c, c + above_k) for code, c in borne.items()]
    return next((problem for check in checks for problem in check.problems()), "")


class _Chosen:
    """One type is chosen; highest_c -- what may be asked for; hottest_c -- what is too hot."""

    def __init__(self, host: Host, code: int, highest_c: float, hottest_c: float) -> None:
        self.host, self.code = host, code
        self.parts, self.controller = host.build.parts, host.build.controller
        self.highest, self.hottest = np.float32(highest_c), np.float32(hottest_c)

    def problems(self) -> Iterator[str]:
        self._power_up(MILD_C)
        found = self.host.step()
        for name, wanted in (("setpoint_c", self.highest), ("guard.maximum_c", self.hottest)):
            if found[name] != wanted:
                yield f"type {self.code}: {name} is {found[name]}, not {wanted}"
        library, loop = self.host.library, self.parts.name
        may_set = getattr(library, f"loop_{loop}_may_set")
        set_maximum = getattr(library, f"guard_{loop}_set_maximum")
        for name, may, most in (
            ("setpoint", may_set, self.highest),
            ("maximum", set_maximum, self.hottest),
        ):
            if not may(most) or may(np.nextafter(most, np.float32(np.inf))):
                yield f"type {self.code}: a {name} of {most} is not the highest"
        if self.parts.programmed:
            yield from self._starts()

    def _power_up(self, celsius: float) -> None:
        """As if the type had been chosen when more was asked for."""
        host, loop = self.host, self.controller.loops[self.parts.name]
        host.renew()
        settings = host.library.settings
        setattr(settings, f"{self.parts.sensor}_thermocouple", self.code)
        setattr(settings, f"{self.parts.name}_setpoint_c", loop.setpoint.maximum_c)
        setattr(settings, f"{self.parts.name}_maximum_c", loop.protection.maximum_c)
        host.library.settings_seal()
        host.set_reading(0, scale_of(self.controller).code(celsius))

    def _starts(self) -> Iterator[str]:
        """Programs that are too hot do not start, and none does from where it is too hot."""
        assert self.controller.programs is not None
        for number, program in enumerate(self.controller.programs.stored, start=1):
            hottest_c = max((each.to_c or 0.0 for each in program.segments), default=0.0)
            for celsius in (MILD_C, float(self.highest) - 1, float(self.highest) + 1):
                self._power_up(celsius)
                self.host.step()
                started = bool(self.host.library.program_start(number))
                if started != (max(hottest_c, celsius) <= self.highest):
                    yield f"type {self.code}: program {number} from {celsius} °C: {started}"
