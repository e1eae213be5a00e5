"""The error budget of an analog chain: the error that each part's tolerance causes in a reading.

Each part is changed by its tolerance, both ways, in the circuit's exact formula; the error is how
far the firmware, which assumes nominal parts, then reads wrong. The worst case is the sum of all
errors; for independent parts the root of the sum of squares is usual.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from heatwright.spec.quantity import number
from heatwright.spec.sensing.circuits import Amplified, Circuit, Divider, Linear, reference_v
from heatwright.spec.sensing.conversion import CODES
from heatwright.spec.sensing.curves import Beta, Curve
from heatwright.spec.sensing.tolerances import (
    RtdTolerances,
    ThermistorTolerances,
    VoltageTolerances,
)

INTERNAL_TOLERANCE_V = {1.1: 0.1, 2.56: 0.26}
"""Tolerances of the chips' internal references, ± V: 1.0 .. 1.2, 2.3 .. 2.8 (data sheets)."""

CLASSES = {"AA": (0.1, 0.0017), "A": (0.15, 0.002), "B": (0.3, 0.005), "C": (0.6, 0.01)}
"""Platinum elements, ±(a + b·|t|) K (IEC 60751:2008, 5.1.1)."""

TABLE_STEPS = 0.5
"""Largest error of the firmware's table against the exact curve, in steps of the ADC."""

SHOWN = 5
"""Places in the printed table; the check of `accuracy` divides the range ten times as finely."""

EDGE = 0.5 / CODES


class Line(NamedTuple):
    """The error that one part causes: its tolerance in words, and the error at each place."""

    part: str
    tolerance: str
    errors: tuple[float, ...]


@dataclass(frozen=True)
class Budget:
    """The errors of a chain's parts at some places, which are temperatures or currents.

    unit -- K for places in °C, A for places in A; untold -- keys of `tolerances` that the spec
    leaves out: their errors are missing.
    """

    unit: str
    places: tuple[float, ...]
    lines: tuple[Line, ...]
    untold: tuple[str, ...]

    @property
    def worst(self) -> tuple[float, ...]:
        """Sum of all errors, each at its worse limit, at each place."""
        return tuple(sum(column) for column in self._columns())

    @property
    def worst_case(self) -> str:
        """The words for `worst`, which excludes parts whose tolerance is left out."""
        return "worst case of the given tolerances" if self.untold else "worst case"

    @property
    def root(self) -> tuple[float, ...]:
        """Root of the sum of squares, at each place."""
        return tuple(math.hypot(*column) for column in self._columns())

    @property
    def heads(self) -> tuple[str, ...]:
        """The places as heads of columns."""
        unit = "A" if self.unit == "A" else "°C"
        return tuple(f"{number(round(place, 3))} {unit}" for place in self.places)

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Parts and sums for people: name, tolerance, and the error at each place."""
        sums = Line(self.worst_case, "", self.worst), Line("root of the squares", "", self.root)
        return [
            (line.part, line.tolerance, *(f"{error:.2f}" for error in line.errors))
            for line in (*self.lines, *sums)
        ]

    def _columns(self) -> Iterator[tuple[float, ...]]:
        return zip(*(line.errors for line in self.lines), strict=True)


class _Part(NamedTuple):
    """A part, its tolerance in words, and the chains with the part at either limit."""

    name: str
    tolerance: str
    off: tuple[Circuit, ...]


@dataclass(frozen=True)
class _Scaled:
    """An element whose resistance is off by a factor."""

    curve: Any
    factor: float

    def ohm(self, celsius: float) -> float:
        return float(self.factor * self.curve.ohm(celsius))

    def celsius(self, ohm: float) -> float:
        return float(self.curve.celsius(ohm / self.factor))


@dataclass(frozen=True)
class _Shifted:
    """An element that is hotter or colder than its resistance shows."""

    chain: Circuit
    per_k: tuple[float, float]
    sign: int

    def ratio(self, celsius: float) -> float:
        first, slope = self.per_k
        return self.chain.ratio(celsius + self.sign * (first + slope * abs(celsius)))


@dataclass(frozen=True)
class _Bridge:
    """The amplifier of `Amplified` part by part, each as a factor of its nominal value.

    Its two inputs: the element and R₀, each fed through its series resistor. Two resistors at each
    set the gain; where they differ, so do the gains of the inputs.
    """

    true: Amplified
    series: float = 1.0
    zero_series: float = 1.0
    zero: float = 1.0
    feedback: float = 1.0
    input: float = 1.0
    ground: float = 1.0
    plus_input: float = 1.0

    def ratio(self, celsius: float) -> float:
        curve, gain = self.true.curve, self.true.gain
        plus = self.true.across(curve.ohm(celsius), self.series)
        minus = self.true.across(curve.zero_ohm * self.zero, self.zero_series)
        below = gain * self.feedback / self.input
        divided = gain * self.ground / (gain * self.ground + self.plus_input)
        return (1 + below) * divided * plus - below * minus


BRIDGE = {
    "series": "series resistor of the element",
    "zero_series": "series resistor of R₀",
    "zero": "R₀",
    "feedback": "gain: feedback",
    "input": "gain: input −",
    "ground": "gain: to ground",
    "plus_input": "gain: input +",
}


def places(sensor: Any, mcu: str, each: int = 1) -> tuple[float, ...]:
    """Choose places evenly over the range; each -- steps from a printed place to the next."""
    low, high = sensor.shown_range(mcu)
    count = each * (SHOWN - 1)
    return tuple(low + (high - low) * place / count for place in range(count + 1))


def budget(sensor: Any, mcu: str, at: Sequence[float] | None = None) -> Budget:
    """Compute the errors by the parts of a sensor on the ADC, at places or over its range."""
    chain, wanted = sensor.circuit(mcu), places(sensor, mcu) if at is None else tuple(at)
    told = sensor.tolerances
    lines = [
        Line(part.name, part.tolerance, tuple(_error(chain, part.off, place) for place in wanted))
        for part in _parts(sensor, mcu, chain)
    ]
    for name, steps in (("ADC", told.adc_steps), ("table", TABLE_STEPS)):
        errors = tuple(_step_error(chain, steps / CODES, place) for place in wanted)
        lines.append(Line(name, f"± {number(steps)} steps", errors))
    return Budget(sensor.unit, wanted, tuple(lines), tuple(_untold(sensor)))


def _error(chain: Circuit, off: Iterable[Circuit], place: float) -> float:
    return max(abs(_read(chain, each.ratio(place)) - place) for each in off)


def _step_error(chain: Circuit, share: float, place: float) -> float:
    ratio = chain.ratio(place)
    return max(abs(_read(chain, ratio + sign * share) - place) for sign in (-1, 1))


def _read(chain: Circuit, ratio: float) -> float:
    """Read a share of the reference as the firmware does; no code is beyond the circuit's ends."""
    low, high = chain.lowest + EDGE, chain.highest - EDGE
    return chain.celsius(min(max(ratio, low), high))


def _parts(sensor: Any, mcu: str, chain: Any) -> Iterator[_Part]:
    told = sensor.tolerances
    yield from _element(told, chain)
    if isinstance(chain, Linear):
        yield from _voltage(sensor, mcu, chain)
    elif told.resistors_percent is not None:
        yield from _resistors(chain, told.resistors_percent)
    yield from _feeds(sensor, mcu, chain)


def _both(name: str, tolerance: str, off: Callable[[float], Any], by: float) -> _Part:
    """Change a part by a share, both ways: the function takes the factor."""
    return _Part(name, f"± {tolerance}", (off(1 - by), off(1 + by)))


def _element(told: Any, chain: Any) -> Iterator[_Part]:
    if isinstance(told, RtdTolerances) and told.element_class is not None:
        per_k = CLASSES[told.element_class]
        off = tuple(_Shifted(chain, per_k, sign) for sign in (-1, 1))
        yield _Part("element", f"class {told.element_class}", off)  # type: ignore[arg-type]
    if not isinstance(told, ThermistorTolerances):
        return
    for name, percent, altered in (
        ("element", told.element_percent, _Scaled),
        ("beta", told.beta_percent, _beta),
    ):
        if percent is not None:
            yield _both(
                name,
                f"{number(percent)} %",
                lambda factor, altered=altered: replace(  # type: ignore[misc]
                    chain, curve=altered(chain.curve, factor)
                ),
                percent / 100,
            )


def _beta(curve: Curve, factor: float) -> Curve:
    assert isinstance(curve, Beta)  # noqa: S101 - others are refused
    return replace(curve, beta_k=factor * curve.beta_k)


def _voltage(sensor: Any, mcu: str, chain: Linear) -> Iterator[_Part]:
    told = sensor.tolerances
    if told.scale_percent is not None:
        yield _both(
            "scale",
            f"{number(told.scale_percent)} %",
            lambda factor: replace(chain, per_k=factor * chain.per_k),
            told.scale_percent / 100,
        )
    if told.offset_v is not None:
        share = told.offset_v / reference_v(sensor, mcu)
        off = tuple(replace(chain, zero=chain.zero + sign * share) for sign in (-1, 1))
        yield _Part("offset", f"± {_volts(told.offset_v)}", off)


def _resistors(chain: Any, percent: float) -> Iterator[_Part]:
    tolerance, by = f"{number(percent)} %", percent / 100
    if isinstance(chain, Divider):
        ohm = chain.resistor_ohm
        yield _both("resistor", tolerance, lambda each: replace(chain, resistor_ohm=each * ohm), by)
        return
    bridge = _Bridge(chain)
    for field, name in BRIDGE.items():
        yield _both(
            name,
            tolerance,
            lambda each, field=field: replace(bridge, **{field: each}),  # type: ignore[misc]
            by,
        )


def _feeds(sensor: Any, mcu: str, chain: Any) -> Iterator[_Part]:
    """Change the feed and the reference: a voltage is then another share of the reference."""
    full_v = reference_v(sensor, mcu)
    by_v = _reference_tolerance_v(sensor, full_v)
    fed_by_reference = _fed_by_reference(sensor)
    if not fed_by_reference and not isinstance(chain, Linear):
        off_v = sensor.tolerances.supply_v
        if off_v is not None:
            by = off_v / fed_v(sensor)
            yield _both("supply", _volts(off_v), lambda each: _Times(chain, each), by)
    if by_v is not None:
        name, off = "reference", (lambda each: _Times(chain, 1 / each))
        if fed_by_reference:
            name, off = "reference (it feeds the circuit, too)", (lambda _: _Times(chain, 1.0))
        yield _both(name, _volts(by_v), off, by_v / full_v)


@dataclass(frozen=True)
class _Times:
    """A chain in which all voltages are off by one factor, compared with the reference."""

    chain: Circuit
    factor: float

    def ratio(self, celsius: float) -> float:
        return self.factor * self.chain.ratio(celsius)


def fed_v(sensor: Any) -> float:
    """Return the voltage that feeds a circuit of resistors, V."""
    if getattr(sensor, "amplifier", None) is not None:
        return float(sensor.amplifier.excitation_v)
    return float(sensor.divider.supply_v or 5.0)


def _fed_by_reference(sensor: Any) -> bool:
    """Whether the ADC's reference also feeds the circuit."""
    told = sensor.tolerances
    return hangs_on_supply(sensor) or getattr(told, "supply_v", None) == "reference"


def hangs_on_supply(sensor: Any) -> bool:
    """Whether the board's supply is both the divider's feed and the ADC's reference."""
    divider = getattr(sensor, "divider", None)
    return divider is not None and divider.supply_v is None and sensor.reference == "supply"


def _reference_tolerance_v(sensor: Any, full_v: float) -> float | None:
    """Return the reference's tolerance, V; for the internal one the data sheet's by default."""
    told: float | None = sensor.tolerances.reference_v
    if told is None and sensor.reference == "internal":
        return INTERNAL_TOLERANCE_V[full_v]
    return told


def _volts(volts: float) -> str:
    return f"{number(1000 * volts)} mV" if volts < 1 else f"{number(volts)} V"


def _untold(sensor: Any) -> Iterator[str]:
    """List the keys of `tolerances` that have an effect and are left out."""
    told, fed = sensor.tolerances, _fed_by_reference(sensor)
    keys: list[tuple[str, Any]]
    if isinstance(told, VoltageTolerances):
        keys = [("scale", told.scale_percent), ("offset", told.offset_v)]
    else:
        element = told.element_class if isinstance(told, RtdTolerances) else told.element_percent
        keys = [("element", element)]
        if hasattr(getattr(sensor, "curve", None), "beta_k"):
            keys.append(("beta", told.beta_percent))
        keys.append(("resistors", told.resistors_percent))
        if not fed:
            keys.append(("supply", told.supply_v))
    if not fed and sensor.reference != "internal":
        keys.append(("reference", told.reference_v))
    return (key for key, value in keys if value is None)


def budgets(controller: Any) -> Iterator[tuple[str, Budget]]:
    """List the budgets of all sensors on the ADC, by their names."""
    for name, sensor in controller.adc_sensors.items():
        yield name, budget(sensor, controller.board.mcu)


def judged(sensor: Any, mcu: str) -> tuple[Budget, int]:
    """Return the budget where an accuracy is required, and the index of its worst place."""
    low_c, high_c = sensor.accuracy.between_c or sensor.range_c
    asked = [each for each in places(sensor, mcu, 10) if low_c < each < high_c]
    found = budget(sensor, mcu, (low_c, *asked, high_c))
    worst = found.worst
    return found, max(range(len(worst)), key=worst.__getitem__)
