"""Whether numbers become the text they should."""

from decimal import ROUND_HALF_UP, Decimal
from fractions import Fraction

import numpy as np

from heatwright.sim.host import Host

LARGEST = 20_000_000
MOST_DECIMALS = 2
HALF_ULP = Fraction(1, 2**24)
"""Relative error of one operation in single precision."""

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
    """Say what is wrong with the text of a value of single precision; empty if nothing."""
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
