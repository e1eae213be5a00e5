"""The fitted plant, as YAML to paste into a spec and as JSON data."""

import math
from shlex import quote
from typing import Any

from heatwright.cli.figures import finite, rounded
from heatwright.sim.identify import Found, Identified
from heatwright.sim.identify.structure import DELAY, LAG
from heatwright.spec.quantity import about, duration, tidy
from heatwright.spec.simulation import AMBIENT

MOST_STEPS = 3
"""Maximum number of steps of power that the heading lists."""

REMARK = 48
"""Column at which the remarks begin."""


def digits(found: Found) -> str:
    """Format a value to a tenth of its uncertainty: further digits would mean nothing."""
    half = max(found.high - found.value, found.value - found.low)
    if found.given or not math.isfinite(half) or half <= 0 or found.value == 0:
        return about(found.value)
    places = 1 - math.floor(math.log10(half))
    # Three to six digits: with fewer the rounded network would no longer fit the record.
    magnitude = math.floor(math.log10(max(abs(found.value), half / 10)))
    places = min(max(places, 2 - magnitude), 5 - magnitude)
    return f"{round(found.value, places) + 0.0:.{max(0, places)}f}"


def interval(found: Found) -> str:
    """Write the 95 % interval."""
    if found.given:
        return "given"
    if not found.told and found.parameter.key not in {LAG, DELAY}:
        return "NOT DETERMINED by this record"
    ends = f"{about(found.low)} .. {about(found.high)} {found.parameter.unit}"
    return ends if found.told else f"{ends}: may be 0"


def block(identified: Identified, name: str) -> str:
    """Write the plant as YAML: the part of a spec below `simulation:`."""
    structure, names = identified.structure, identified.structure.names
    found = dict(zip((each.parameter.key for each in identified.found), identified.found))  # noqa: B905
    *inner, lag, delay, ambient = identified.found
    lines = [*_heading(identified, name), "simulation:", _line("  ambient: ", ambient)]
    lines += ["  plant:", "    kind: thermal_network", "    nodes:"]
    for node in structure.nodes:
        lines.append(_line(f"      {node}: ", found[f"capacity_{node}"]))
    lines.append("    links:")
    for node, end in zip(structure.nodes, (*structure.nodes[1:], AMBIENT), strict=True):
        each = found[f"resistance_{node}"]
        text = f"      - {{between: [{node}, {end}], resistance: {digits(each)} K/W}}"
        lines.append(_remark(text, interval(each)))
    lines.append(f"    heat: {{{names.heater}: {names.body}}}")
    lines += ["    sense:", f"      {names.sensor}:", f"        node: {names.body}"]
    lines += [_line(f"        {each.parameter.key}: ", each) for each in (lag, delay)]
    assert len(inner) == 2 * structure.bodies  # noqa: S101 - what structure.parameters promises
    return "\n".join(lines) + "\n"


def _line(start: str, found: Found) -> str:
    return _remark(f"{start}{digits(found)} {found.parameter.unit}", interval(found))


def _remark(text: str, remark: str) -> str:
    return f"{text:<{REMARK}} # {remark}"


def _heading(identified: Identified, name: str) -> list[str]:
    record = identified.record
    lines = [
        f"heatwright identify {quote(tidy(name))}",
        f"{record.rows} readings in {duration(round(record.duration_s, 1))}; {_steps(identified)}",
        f"Fit error {about(identified.rms_k)} K rms, {about(identified.worst_k)} K at most; the "
        f"model explains {identified.percent:.1f} % of the movement.",
        f"Noise of the readings {about(identified.noise_k)} K. Remarks: 95 % intervals.",
        *(f"WARNING: {warning}." for warning in identified.warnings),
    ]
    return [f"# {line}" for line in lines]


def _steps(identified: Identified) -> str:
    steps = identified.record.steps
    told = [
        f"{about(before_w)} → {about(after_w)} W after {duration(round(time_s, 1))}"
        for time_s, before_w, after_w in sorted(steps, key=lambda step: -abs(step[2] - step[1]))
    ][:MOST_STEPS]
    if not told:
        return f"{about(float(identified.record.powers_w[0]))} W from the first reading on."
    count = f"{len(steps)} changes of power, the largest: " if len(steps) > MOST_STEPS else ""
    return f"{count}{', '.join(told)}."


def as_json(identified: Identified) -> dict[str, Any]:
    """Return the fit as JSON data; units are J/K, K/W, s, °C, K and W."""
    record = identified.record
    return {
        "readings": record.rows,
        "duration_s": rounded(record.duration_s),
        "steps": [
            {"time_s": rounded(time_s), "before_W": rounded(a), "after_W": rounded(b)}
            for time_s, a, b in record.steps
        ],
        "fit": {
            "rms": rounded(identified.rms_k),
            "worst": rounded(identified.worst_k),
            "noise": rounded(identified.noise_k),
            "percent": rounded(identified.percent),
        },
        "parameters": {
            each.parameter.key: {
                "value": rounded(each.value),
                "low": finite(each.low),
                "high": finite(each.high),
                "unit": each.parameter.unit,
                "told": each.told,
                "given": each.given,
            }
            for each in identified.found
        },
        "warnings": list(identified.warnings),
    }
