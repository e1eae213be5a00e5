# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures as docs/benchmarks.md."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from startup import PAIRS

PICTURE = "benchmarks.svg"

INTRODUCTION = """\
# Benchmarks

`make bench ARGS=--page` has measured the figures of this page and drawn its picture. A **yard** \
is the processor time of 10⁷ additions in a plain Python loop, so that figures from a fast and a \
slow computer can be compared. All times are processor times, summed over all processes of a \
command; each is the shortest of several measurements. Where wall-clock time is meant, the text \
says so. Programs that are compared ran alternately. `make peers` installs the others, ESPHome \
and avr8js; plain simavr comes with `make setup`.

"""


def page(found: dict[str, Any]) -> str:
    """Return the page; a part that was not measured is left out."""
    host = found["machine"]
    text = f"Measured on: {host['processor']}, {host['cores']} cores, Python {host['python']}.\n\n"
    parts = {
        "startup": startup, "verify": verify, "loops": loops, "cores": cores, "growth": growth,
        "campaigns": campaigns, "seat": seat,
    }  # fmt: skip
    told = [write(found[part]) for part, write in parts.items() if found.get(part)]
    return f"{INTRODUCTION}{text}![The figures]({PICTURE})\n\n" + "\n".join(told)


def startup(found: dict[str, Any]) -> str:
    """Write the section on start-up: ours and ESPHome's, in yards."""
    yard, ours, theirs = found["yard_s"], found["ours"], found["esphome"]
    rows = []
    for name, took_s in ours.items():
        pair = PAIRS.get(name)
        other = theirs.get(pair) if pair else None
        peer = (
            ("–", "–")
            if other is None
            else (f"`{pair}`: {other / yard:.2f}", f"{took_s / other:.2f}")
        )
        rows.append((f"`{name}`", f"{took_s / yard:.2f}", *peer))
    return f"""## Start-up

The chamber, {found["lines"]["ours"]} lines; for ESPHome the same machine, as far as its language \
can describe it, {found["lines"]["theirs"]} lines. `check` without `--quick` also runs the \
reference model on the simulated machine, once through the scenario and once on each variant of a \
healthy machine; ESPHome has no such check.

{table(("command", "yards", "ESPHome's, yards", "ratio"), rows)}"""


def verify(found: dict[str, Any]) -> str:
    """Write how long `verify` takes."""
    rows = [
        (name, each["faults"], f"{each['processor_s'] / each['yard_s']:.1f}")
        for name, each in found.items()
    ]
    return f"""## verify

All the evidence for one spec; its binary was compiled before.

{table(("spec", "faults", "yards"), rows)}"""


def loops(found: dict[str, Any]) -> str:
    """Write the speed of closed loops."""
    yard = found["yard_s"]
    heads = ["closed loop", "times real time", "its limit", "yards per simulated hour",
             "processor", "chips, plant", "Python"]  # fmt: skip
    rows = []
    for name, runs in found.items():
        if name == "yard_s":
            continue
        now, before = runs["now"], runs.get("before")
        row = [name, count(now["speed"]), count(now["limit"])]
        row.append(f"{3600 / now['speed'] / yard:.1f}")
        row += [f"{share:.0%}" for share in shares(now)] if "in_c" in now else ["–"] * 3
        rows.append(row + ([f"{now['speed'] / before['speed']:.2f}"] if before else []))
    if any(len(row) > len(heads) for row in rows):
        heads.append("against the other checkout")
    return f"""## Closed loop

The binary runs the scenario of the spec. The limit is the speed that would be reached if only \
the processor had to be simulated: its time is the number of cycles in which the processor is \
awake, times the time for one such cycle with nothing at its pins, wake-ups included. This is the \
share in the column *processor*. *Chips, plant* is the other time in C, with the chips that C \
calls in Python; *Python* is the time between two calls of C.

{table(heads, rows)}"""


def shares(run: dict[str, Any]) -> tuple[float, float, float]:
    """Return the parts of the time: the processor, what else C does, Python."""
    processor = min(run["speed"] / run["limit"], run["in_c"])
    return processor, run["in_c"] - processor, 1 - run["in_c"]


def cores(found: dict[str, Any]) -> str:
    """Write the speed of simulated processors."""
    names = list(dict.fromkeys(name for each in found.values() for name in each))
    rows = [
        (program, *(count(speeds.get(name)) for name in names), ratio(speeds))
        for program, speeds in found.items()
    ]
    return f"""## The processor alone

The same image on each simulator, with nothing at its pins; speeds are multiples of real time.

{table(("program", *names, "heatwright ÷ simavr"), rows)}"""


def growth(found: dict[str, Any]) -> str:
    """Write the cost of more loops, and of longer runs."""
    yard = found["yard_s"]
    sides = [
        (each["loops"], f"{each['simulate_s'] / yard:.1f}", each["faults"],
         f"{each['verify_s'] / yard:.1f}", f"{each['verify_s'] / yard / each['faults']:.2f}")
        for each in found["loops"]
    ]  # fmt: skip
    lengths = [
        (f"{each['hours']:g}", f"{each['simulate_s'] / yard:.1f}") for each in found["length"]
    ]
    heads = ("loops", "simulate 30 min, yards", "faults", "verify, yards", "yards per fault")
    return f"""## Growth

One ATmega2560 controls several chambers, each with a plant of its own; more loops have more \
faults.

{table(heads, sides)}
The chamber, simulated for longer:

{table(("hours", "simulate, yards"), lengths)}"""


def campaigns(found: dict[str, Any]) -> str:
    """Write the cost of a campaign."""
    yard, runs = found["yard_s"], found["runs"]
    (first, *_) = found["processes"].values()
    rows = [
        (number, f"{1000 / runs * each['processor_s'] / yard:.0f}",
         f"{1000 / runs * each['wall_s'] / yard:.0f}", f"{first['wall_s'] / each['wall_s']:.2f}")
        for number, each in found["processes"].items()
    ]  # fmt: skip
    heads = ("processes", "processor, yards for 1,000 runs", "wall clock, yards", "speed-up")
    return f"""## Campaigns

Random variants of the spec's chamber, 30 simulated minutes each: {runs} runs, scaled to 1,000.

{table(heads, rows)}"""


def seat(found: dict[str, Any]) -> str:
    """Write how quick the bench's page is."""
    ratio = found["simulated_s"] / found["watched_s"]
    return f"""## The bench in a browser

Headless Chromium shows the chamber at real time: from a key to its effect on the page's LCD pass \
{found["key_median_ms"]:.0f} ms by the clock on the wall (median of {found["keys"]} keys; at most \
{found["key_most_ms"]:.0f} ms). A firing of the kiln over {found["hours"]:.1f} h, at full speed \
and watched, goes at {ratio:.2f} times the speed of `simulate`, by the processor time of the \
command (the least of {found["times"]} each).
"""


def ratio(speeds: dict[str, float]) -> str:
    """Return how many times faster than plain simavr."""
    return f"{speeds['heatwright'] / speeds['simavr']:.1f}" if "simavr" in speeds else "–"


def count(value: float | None) -> str:
    """Write a number of three digits."""
    return "–" if value is None else f"{float(f'{value:.3g}'):,.0f}"


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Write a table of Markdown; all columns but the first are numbers."""
    lines = [heads, ("---", *["---:"] * (len(heads) - 1)), *rows]
    return "".join(f"| {' | '.join(map(str, line))} |\n" for line in lines)
