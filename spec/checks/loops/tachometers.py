"""Tachometers of fans: pulses that can be seen and counted, limits that a healthy fan keeps."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.outputs import Tachometer
from heatwright.spec.problems import Path
from heatwright.spec.proofs import proofs
from heatwright.spec.quantity import duration

SLOW_SHARE, FAST_SHARE = 0.8, 1.2
"""Slowest and fastest speed of a healthy fan, as shares of its nominal speed. Data sheets allow
±10 %, and the supply may add as much."""
FASTEST_PULSES_HZ = 350.0
"""Highest rate that can be counted: the pin is sampled every ms, up to 0.1 ms late, and a pulse may
be low, or high, for only 40 % of its period."""
SLOWEST_PULSES_HZ = 8.0
"""Lowest rate: its counting window lasts 2 s, and the window's count of ticks fits into a byte."""
MOST_RATIO = 12.0
"""Highest ratio of maximum to minimum: a window has 16 pulses at the minimum, and the count at the
maximum must fit into a byte."""
AIRFLOW = "Use an airflow switch"
STARTS_S = 1.0
"""Time in which a fan reaches its speed."""


def tachometers_can_be_counted(controller: Controller) -> Findings:
    """Find tachometers with pulses that cannot be counted, or limits that a healthy fan breaks."""
    for name, proof in proofs(controller).items():
        if proof.tachometer is None:
            continue
        path: Path = ("outputs", name, "proof")
        yield from _limits(proof.tachometer, (*path, "tachometer"))
        least_s = round(STARTS_S + 2 * proof.tachometer.window_s, 2)
        if proof.within_s < least_s:
            yield Finding(
                (*path, "within"),
                f"a fan needs a second to start, and counting its pulses two windows of "
                f"{duration(proof.tachometer.window_s)}",
                f"Use at least {duration(least_s)}",
                ((*path, "tachometer"),),
            )


def _limits(fan: Tachometer, path: Path) -> Findings:
    slow_rpm, fast_rpm = SLOW_SHARE * fan.speed_rpm, FAST_SHARE * fan.speed_rpm
    if fan.slowest_rpm > slow_rpm:
        yield Finding(
            (*path, "minimum"),
            f"a healthy fan of {fan.speed_rpm:g} rpm may turn at {slow_rpm:g} rpm",
            f"Use at most {slow_rpm:g} rpm",
        )
    if fan.fastest_rpm < fast_rpm:
        yield Finding(
            (*path, "maximum"),
            f"a healthy fan of {fan.speed_rpm:g} rpm may turn at {fast_rpm:g} rpm",
            f"Use at least {fast_rpm:g} rpm",
        )
    most_rpm = FASTEST_PULSES_HZ * 60 / fan.pulses
    if fan.fastest_rpm > most_rpm:
        yield Finding(
            (*path, "maximum" if fan.maximum_rpm is not None else "speed"),
            f"{fan.fastest_rpm:g} rpm are {fan.pulses_hz(fan.fastest_rpm):g} pulses a second, and "
            f"the firmware can count at most {FASTEST_PULSES_HZ:g}",
            f"{AIRFLOW}, or set a maximum of {most_rpm:g} rpm or less"
            if fast_rpm <= most_rpm
            else AIRFLOW,
            ((*path, "pulses"),),
        )
    least_rpm = SLOWEST_PULSES_HZ * 60 / fan.pulses
    if fan.slowest_rpm < least_rpm:
        yield Finding(
            (*path, "minimum" if fan.minimum_rpm is not None else "speed"),
            f"{fan.slowest_rpm:g} rpm are {fan.pulses_hz(fan.slowest_rpm):g} pulses a second: it "
            "would take more than 2 s to detect that the pulses stop",
            f"{AIRFLOW}, or set a minimum of {least_rpm:g} rpm or more"
            if least_rpm <= slow_rpm
            else AIRFLOW,
            ((*path, "pulses"),),
        )
    elif fan.fastest_rpm > MOST_RATIO * fan.slowest_rpm:
        yield Finding(
            (*path, "maximum" if fan.maximum_rpm is not None else "minimum"),
            f"{fan.fastest_rpm:g} rpm are more than {MOST_RATIO:g} times {fan.slowest_rpm:g} rpm: "
            "no counting window suits both",
            f"Use a minimum of {fan.fastest_rpm / MOST_RATIO:g} rpm or more, or a smaller maximum",
            ((*path, "minimum" if fan.maximum_rpm is not None else "maximum"),),
        )
