# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures as docs/benchmarks.md."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from startup import PAIRS

PICTURE = "benchmarks.svg"

INTRODUCTION = """\
# Benchmarks

`make bench ARGS=--page` has measured this page and drawn its picture. A **yard** is the processor \
time of 10⁷ additions in a plain Python loop, so that a quick machine and a slow one tell much the \
same. All times are of the processor, with all processes of a command, the least of several, \
unless the clock on the wall is named; what is compared took turns. `make peers` installs the \
others, ESPHome and avr8js; plain simavr comes with `make setup`.

"""


def page(found: dict[str, Any]) -> str:
    """Return the page; a part that was not measured is left out."""
    host = found["machine"]
    text = f"Measured on: {host['processor']}, {host['cores']} cores, Python {host['python']}.\n\n"
    parts = {
        "startup": startup, "verify": verify, "loops": loops, "cores": cores, "growth": growth,
        "campaigns": campaigns,
    }  # fmt: skip
    told = [write(found[part]) for part, write in parts.items() if part in found]
    return f"{INTRODUCTION}{text}![The figures]({PICTURE})\n\n" + "\n".join(told)


def startup(found: dict[str, Any]) -> str:
    """Tell start-up: in yards, and of ESPHome's."""
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

The chamber, {found["lines"]["ours"]} lines; for ESPHome the same machine as far as it has words \
for it, {found["lines"]["theirs"]} lines. `check` without `--quick` also runs the machine by the \
reference model, once in its scenario and once on each machine that is well; ESPHome has nothing \
like it.

{table(("command", "yards", "ESPHome's, yards", "ratio"), rows)}"""


def verify(found: dict[str, Any]) -> str:
    """Tell how long `verify` takes."""
    rows = [
        (name, each["faults"], f"{each['processor_s'] / each['yard_s']:.1f}")
        for name, each in found.items()
    ]
    return f"""## verify

All the evidence for one spec, its binary compiled before.

{table(("spec", "faults", "yards"), rows)}"""


def loops(found: dict[str, Any]) -> str:
    """Tell the speed of closed loops."""
    yard = found["yard_s"]
    heads = ["closed loop", "times real time", "its limit", "yards for an hour",
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

The scenario of the spec, by its binary. The limit: the cycles in which the processor is awake, \
times what one takes with nothing at its pins, its share of the wakes included; that is the \
processor's part of the time. What else C does is chips and plant, those chips included that C \
asks in Python; the remainder is Python between two calls of C.

{table(heads, rows)}"""


def shares(run: dict[str, Any]) -> tuple[float, float, float]:
    """Return the parts of the time: the processor, what else C does, Python."""
    processor = min(run["speed"] / run["limit"], run["in_c"])
    return processor, run["in_c"] - processor, 1 - run["in_c"]


def cores(found: dict[str, Any]) -> str:
    """Tell the speed of simulated processors."""
    names = list(dict.fromkeys(name for each in found.values() for name in each))
    rows = [
        (program, *(count(speeds.get(name)) for name in names), ratio(speeds))
        for program, speeds in found.items()
    ]
    return f"""## The processor alone

The same image on each, in times real time, with nothing at its pins.

{table(("program", *names, "heatwright to simavr"), rows)}"""


def growth(found: dict[str, Any]) -> str:
    """Tell what more of everything costs."""
    yard = found["yard_s"]
    sides = [
        (each["loops"], f"{each['simulate_s'] / yard:.1f}", each["faults"],
         f"{each['verify_s'] / yard:.1f}", f"{each['verify_s'] / yard / each['faults']:.2f}")
        for each in found["loops"]
    ]  # fmt: skip
    lengths = [
        (f"{each['hours']:g}", f"{each['simulate_s'] / yard:.1f}") for each in found["length"]
    ]
    heads = ("loops", "simulate 30 min, yards", "faults", "verify, yards", "yards for a fault")
    return f"""## Growth

Chambers side by side under one ATmega2560, each with a plant of its own; more loops have more \
faults.

{table(heads, sides)}
The chamber, simulated for longer:

{table(("hours", "simulate, yards"), lengths)}"""


def campaigns(found: dict[str, Any]) -> str:
    """Tell what a campaign costs."""
    yard, runs = found["yard_s"], found["runs"]
    (first, *_) = found["processes"].values()
    rows = [
        (number, f"{1000 / runs * each['processor_s'] / yard:.0f}",
         f"{1000 / runs * each['wall_s'] / yard:.0f}", f"{first['wall_s'] / each['wall_s']:.2f}")
        for number, each in found["processes"].items()
    ]  # fmt: skip
    heads = ("processes", "processor, yards for 1,000 runs", "on the wall, yards", "sooner by")
    return f"""## Campaigns

Chambers drawn about that of the spec, 30 simulated minutes each: {runs} of them, in proportion.

{table(heads, rows)}"""


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
