import math
from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from heatwright.spec import units
from heatwright.spec.quantity import Quantity, QuantityRange, about, duration, parse, rounded_up
from heatwright.spec.units import Dimension

DIMENSIONS = [value for value in vars(units).values() if isinstance(value, Dimension)]


READ: list[tuple[Dimension, dict[str, float]]] = [
    (units.TEMPERATURE, {
        "50 °C": 50.0, "50C": 50.0, "50 ° C": 50.0, "50 ℃": 50.0, "50\u00a0°C": 50.0,
        "122 °F": 50.0, "-40 F": -40.0, "323.15 K": 50.0, "−10 °C": -10.0, "-0 °C": 0.0,
    }),
    (units.DIFFERENCE, {"2 K": 2.0, "62.5 mK": 0.0625}),
    (units.DURATION, {
        "20 ms": 0.02, "0.1 ms": 0.0001, "64 us": 0.000064, "64 µs": 0.000064, "64 μs": 0.000064,
        "1.5 min": 90.0, "2 h": 7200.0, "1 d": 86400.0,
    }),
    (units.POWER, {"240 W": 240.0, "2.4kW": 2400.0, "1e3 W": 1000.0}),
    (units.FREQUENCY, {"16 MHz": 16e6, "1 kHz": 1000.0}),
    (units.RATE, {"6 K/min": 0.1}),
    (units.PERCENT, {"80 %": 80.0}),
    (units.BITS, {"12bit": 12.0, "12 bits": 12.0}),
    (units.CAPACITY, {"4.5 kJ/K": 4500.0}),
    (units.THERMAL_RESISTANCE, {"0.173 K / W": 0.173}),
    (units.RESISTANCE, {"4.7 k\u2126": 4700.0, "4.7 kΩ": 4700.0, "4.7 kohm": 4700.0}),
    (units.VOLTAGE, {"5 V": 5.0}),
    (units.CURRENT, {"80 mA": 0.08}),
    (units.AREA, {"0.005 m²": 0.005, "50 cm2": 0.005}),
    (units.FILM, {"8.7 W/m²K": 8.7, "8.7 W/(m²·K)": 8.7}),
]  # fmt: skip


@pytest.mark.parametrize(("dimension", "texts"), READ, ids=[each.name for each, _ in READ])
def test_reads(dimension: Dimension, texts: dict[str, float]) -> None:
    for text, expected in texts.items():
        found = parse(text, dimension)
        assert (text, found) == (text, expected)
        assert math.copysign(1, found) == math.copysign(1, expected)


REFUSED = [
    "", " ", "°C", "1 2 °C", "1e °C", "0x10 °C", "1_000 °C", "nan °C", "inf °C", "1..2 °C",
    "1 °C °C", "١ °C", "1e9999 °C", "1e999 °C", "5 °Ré", "50 % °C", "1,5 °C", "½ °C",
    "1\u200b °C", "x" * 65 + " °C", "1" + " " * 80 + "°C",
    50, 50.0, math.nan, math.inf, True, None, [], {}, ("50 °C",),
]  # fmt: skip


@pytest.mark.parametrize("value", REFUSED)
def test_refuses(value: object) -> None:
    with pytest.raises(PydanticCustomError) as caught:
        parse(value, units.TEMPERATURE)
    assert caught.value.context is not None
    assert caught.value.context["reason"]
    assert caught.value.context["remedy"]


@given(st.decimals(-1000, 1000, allow_nan=False, allow_infinity=False, places=4))
def test_rounds_once(value: Decimal) -> None:
    assert parse(f"{value} ms", units.DURATION) == float(value / 1000)


@given(st.text(max_size=80))
def test_any_text_is_read_or_refused(text: str) -> None:
    for dimension in DIMENSIONS:
        try:
            assert math.isfinite(parse(text, dimension))
        except PydanticCustomError as error:
            context = error.context or {}
        else:
            continue
        assert context["reason"].isprintable()
        assert context["remedy"]


def test_limits() -> None:
    quantity = Quantity(units.DURATION, least=0.01, most=10)
    assert (quantity.read_one("10 ms"), quantity.read_one("10 s")) == (0.01, 10)
    for text in ("9 ms", "11 s"):
        with pytest.raises(PydanticCustomError):
            quantity.read_one(text)


def test_choices_keep_their_type() -> None:
    found = Quantity(units.BITS, choices=(9, 10)).read_one("9 bit")
    assert found == 9
    assert isinstance(found, int)


@pytest.mark.parametrize("text", ["48.5 °C .. 51.9 °C", "48.5 °C..51.9 °C", "119.3 °F .. 51.9 C"])
def test_ranges(text: str) -> None:
    assert QuantityRange(units.TEMPERATURE).read_range(text) == (48.5, 51.9)


@pytest.mark.parametrize("text", ["48.5 .. 51.9 °C", "48.5 °C", "2 °C .. 1 °C", "..", 5])
def test_ranges_refused(text: object) -> None:
    with pytest.raises(PydanticCustomError):
        QuantityRange(units.TEMPERATURE).read_range(text)


@pytest.mark.parametrize(
    "text", ["0 s", "780 ms", "1 s", "1.5 s", "1 min", "90 s", "255 s", "10 min", "1 h"]
)
def test_durations_in_messages_can_be_pasted_back(text: str) -> None:
    assert duration(parse(text, units.DURATION)) == text


@given(st.floats(1e-6, 1e6))
def test_an_advised_limit_is_never_too_little(value: float) -> None:
    advised = float(rounded_up(value))
    assert value * (1 - 1e-12) <= advised <= value * 1.011
    assert abs(float(about(value)) - value) <= value * 0.00501
