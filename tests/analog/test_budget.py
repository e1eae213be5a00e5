"""What tolerances cost: each part's share of the budget, by the judges' own circuits and a search
for what the firmware reads; by hand where a hand can do it."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter
from rig.firmware import example
from rig.sensors import CIRCUITS, sensor
from scipy.optimize import brentq

from heatwright.sim.circuits import reference_v, shares
from heatwright.sim.circuits.elements import element_ohm
from heatwright.spec import BOARDS, BetaCurve, CurrentSensor, Rtd, Sensor
from heatwright.spec.sensing.budget import budget, judged

UNO = BOARDS["uno"]
TOLD = {
    "thermistor": {"element": "0.7 %", "resistors": "0.4 %"},
    "rtd": {"element": "B", "resistors": "0.05 %"},
    "analog": {"scale": "0.3 %", "offset": "4 mV"},
}
REFERENCE_V, SUPPLY_V, STEPS = 0.006, 0.009, 1.5
IEC = {"AA": (0.1, 0.0017), "A": (0.15, 0.002), "B": (0.3, 0.005), "C": (0.6, 0.01)}


def told(name: str, **more: Any) -> Any:
    """The sensor of a circuit, with tolerances."""
    plain = sensor(name)
    given = {**TOLD[plain.kind], "reference": "6 mV", "adc": STEPS, **more}
    if plain.kind == "thermistor" and isinstance(plain.curve, BetaCurve):
        given["beta"] = "0.5 %"
    if plain.kind != "analog" and not ratiometric(plain):
        given.setdefault("supply", "9 mV")
    kind = type(plain).model_fields["tolerances"].annotation
    return plain.model_copy(update={"tolerances": TypeAdapter(kind).validate_python(given)})


def ratiometric(part: Any) -> bool:
    own = part.kind == "rtd" and part.amplifier is not None
    return part.reference == "supply" and not own and part.divider.supply_v is None


def divided(part: Any, ohm: float, *, resistor: float = 1.0) -> float:
    pull = resistor * (part.divider.pull_up_ohm or part.divider.pull_down_ohm)
    lower = ohm if part.divider.pull_up_ohm else pull
    return (part.divider.supply_v or 5.0) * lower / (ohm + pull)


def amplified(part: Rtd, ohm: float, off: int | None = None, by: float = 1.0) -> float:
    """Volts of an ideal operational amplifier with its resistors, by its two node equations."""
    amplifier, zero = part.amplifier, 100.0 if part.element == "pt100" else 1000.0
    assert amplifier is not None
    whole = np.ones(7)
    if off is not None:
        whole[off] = by
    fed, fed_zero, zero = (*whole[:2], whole[2] * zero)
    feedback, first, ground, second = np.array([amplifier.gain, 1, amplifier.gain, 1]) * whole[3:]
    full, series = amplifier.excitation_v, amplifier.series_ohm
    plus, minus = full / series / fed * ohm, full / series / fed_zero * zero
    if amplifier.feed == "resistors":
        plus, minus = full * ohm / (ohm + series * fed), full * zero / (zero + series * fed_zero)
    # Kirchhoff at both inputs, which have one voltage: unknown are that and the output.
    conductances = [[1 / second + 1 / ground, 0.0], [1 / first + 1 / feedback, -1 / feedback]]
    return float(np.linalg.solve(conductances, [plus / second, minus / first])[1])


def volts(part: Any, celsius: float, **off: Any) -> float:
    if part.kind == "analog":
        scale = part.scale_v_per_k * off.get("scale", 1.0)
        return part.offset_v + off.get("offset", 0.0) + scale * celsius
    ohm = float(element_ohm(part, np.array([celsius]))[0]) * off.get("element", 1.0)
    if part.kind == "rtd" and part.amplifier is not None:
        return amplified(part, ohm, *off.get("bridge", ()))
    return divided(part, ohm, resistor=off.get("resistor", 1.0))


def feeds(part: Any, full_v: float) -> Iterator[tuple[str, Callable[[float, int], float]]]:
    if part.kind != "analog" and ratiometric(part):
        yield "reference (it feeds the circuit, too)", lambda at, _: volts(part, at) / full_v
        return
    if part.kind != "analog":
        amplifier = getattr(part, "amplifier", None)
        fed_v = amplifier.excitation_v if amplifier else part.divider.supply_v or 5.0
        yield "supply", lambda at, sign: volts(part, at) / full_v * (1 + SUPPLY_V / fed_v * sign)
    yield "reference", lambda at, sign: volts(part, at) / (full_v + REFERENCE_V * sign)


def parts(part: Any) -> Iterator[tuple[str, Callable[[float, int], float]]]:
    """List each part, and the share of the reference that is seen with it off to either side."""
    full_v = reference_v(part, UNO)

    def seen(**off: Callable[[int], Any]) -> Callable[[float, int], float]:
        return lambda at, sign: volts(part, at, **{k: v(sign) for k, v in off.items()}) / full_v

    if part.kind == "rtd":
        a, b = IEC["B"]
        yield "element", lambda at, sign: volts(part, at + sign * (a + b * abs(at))) / full_v
    elif part.kind == "thermistor":
        yield "element", seen(element=lambda sign: 1 + 0.007 * sign)
    if part.kind == "thermistor" and isinstance(part.curve, BetaCurve):
        curve = part.curve

        def other(at: float, sign: int) -> float:
            changed = curve.model_copy(update={"beta_k": curve.beta_k * (1 + 0.005 * sign)})
            return volts(part.model_copy(update={"curve": changed}), at) / full_v

        yield "beta", other
    if part.kind == "analog":
        yield "scale", seen(scale=lambda sign: 1 + 0.003 * sign)
        yield "offset", seen(offset=lambda sign: 0.004 * sign)
    elif part.kind == "rtd" and part.amplifier is not None:
        names = ("series resistor of the element", "series resistor of R₀", "R₀", "gain: feedback")
        for index, name in enumerate((*names, "gain: input −", "gain: to ground", "gain: input +")):
            yield name, seen(bridge=lambda sign, index=index: (index, 1 + 0.0005 * sign))
    else:
        percent = 0.0005 if part.kind == "rtd" else 0.004
        yield "resistor", seen(resistor=lambda sign: 1 + percent * sign)
    yield from feeds(part, full_v)
    for name, steps in (("ADC", STEPS), ("table", 0.5)):
        yield name, lambda at, sign, steps=steps: volts(part, at) / full_v + sign * steps / 1024


def read_c(part: Any, share: float, about_c: float) -> float:
    """Search for the temperature at which the true chain shows a share of the reference."""
    full_v = reference_v(part, UNO)
    low_c, high_c = part.range_c
    room = (high_c - low_c) / 10
    wanted = lambda at: volts(part, at) / full_v - share  # noqa: E731
    return float(brentq(wanted, max(about_c - room, low_c), min(about_c + room, high_c), xtol=1e-9))


@pytest.mark.parametrize("name", CIRCUITS)
def test_each_part_costs_what_the_judges_find(name: str) -> None:
    part = told(name)
    low_c, high_c = part.range_c
    at = [low_c + share * (high_c - low_c) for share in (0.2, 0.45, 0.8)]
    found = budget(part, UNO.mcu, at)
    assert found.untold == ()
    for place in at:  # the formulae above are those of the judges' circuits
        share = float(shares(part, UNO, place))
        assert volts(part, place) / reference_v(part, UNO) == pytest.approx(share, rel=1e-12)
    expected = {
        label: [max(abs(read_c(part, off(c, sign), c) - c) for sign in (-1, 1)) for c in at]
        for label, off in parts(part)
    }
    due = {label: pytest.approx(each, rel=1e-5, abs=1e-7) for label, each in expected.items()}
    assert {line.part: line.errors for line in found.lines} == due
    columns = list(zip(*expected.values(), strict=True))
    assert found.worst == pytest.approx([sum(column) for column in columns], rel=1e-5)
    roots = [math.sqrt(sum(each**2 for each in column)) for column in columns]
    assert found.root == pytest.approx(roots, rel=1e-5)


def test_a_supply_that_is_the_reference_cancels() -> None:
    apart, same = told("feeder"), told("feeder", supply="reference")
    (found,) = [line for line in budget(same, UNO.mcu).lines if line.part.startswith("reference")]
    assert found.errors == pytest.approx((0.0,) * 5, abs=1e-9)
    assert not any(line.part == "supply" for line in budget(same, UNO.mcu).lines)
    assert budget(same, UNO.mcu).worst[-1] < budget(apart, UNO.mcu).worst[-1] - 1


@pytest.mark.parametrize(
    ("kind", "at_c", "error_k"),
    [("AA", 100, 0.27), ("A", 100, 0.35), ("B", -50, 0.55), ("C", 0, 0.6)],
)
def test_classes_are_the_standards(kind: str, at_c: float, error_k: float) -> None:
    part = told("frost", element=kind)
    line = budget(part, UNO.mcu, [at_c]).lines[0]
    assert (line.part, line.errors[0]) == ("element", pytest.approx(error_k, abs=1e-9))


def test_a_current_by_hand() -> None:
    """0.5 V/A at a supply of 5 V: 1 % of 4 A are 40 mA, 10 mV are 20 mA; 4.9 V are 4 A · 5/4.9."""
    part = TypeAdapter(Sensor).validate_python(
        {"kind": "current", "pin": "A1", "scale": "0.5 V/A", "tolerances":
         {"scale": "1 %", "offset": "10 mV", "reference": "100 mV", "adc": 3}}
    )  # fmt: skip
    assert isinstance(part, CurrentSensor)
    found = budget(part, UNO.mcu, [4.0])
    errors = {line.part: line.errors[0] for line in found.lines}
    step_a = 5 / 1024 / 0.5
    due = {"scale": 0.04, "offset": 0.02, "reference": 4 * (5 / 4.9 - 1), "ADC": 3 * step_a}
    assert found.unit == "A"
    assert errors == pytest.approx(due | {"table": 0.5 * step_a})


@pytest.mark.parametrize(
    ("name", "untold"),
    [
        ("hotend", "element beta resistors"),
        ("low_supply", "element beta resistors supply reference"), ("points", "element resistors"),
        ("feeder", "element resistors supply reference"), ("tmp36", "scale offset reference"),
        ("lm35", "scale offset"),
    ],
)  # fmt: skip
def test_what_is_not_told_is_said(name: str, untold: str) -> None:
    """The internal reference's is in the data sheets; one that feeds the circuit costs nothing."""
    found = budget(sensor(name), UNO.mcu)
    assert " ".join(found.untold) == untold
    lm35 = ["reference"] * (name == "lm35")
    assert [line.part for line in found.lines] == [*lm35, "ADC", "table"]


def test_the_accuracy_is_judged_where_it_is_worst() -> None:
    feeder = example("feeder").controller.sensors["nozzle"]
    found, place = judged(feeder, "atmega328p")
    assert (found.places[place], found.worst[place]) == (250.0, max(found.worst))
    assert 180.0 in found.places
    assert found.worst[place] == budget(feeder, "atmega328p", [250.0]).worst[0]
