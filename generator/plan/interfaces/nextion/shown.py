"""The contents of the components of the touch display's pages, as C."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from heatwright.generator.plan.source import Source
from heatwright.spec import Nextion, facts_of
from heatwright.spec.nextion import Page, display_pages, selectable_types


@dataclass(frozen=True, slots=True)
class What:
    """One content: its C name, its form, and the C expression of its number."""

    macro: str
    form: str
    number: str


@dataclass(frozen=True, slots=True)
class Shows:
    """A component with a content: its name without its row, its row, and the content."""

    name: str
    row: int
    what: str


@dataclass(frozen=True, slots=True)
class Begin:
    """A page, and the index of its first component."""

    name: str
    first: int
    size: int


ENERGY = "steps((float)program.energy, NEXTION_HUNDREDTHS_OF_KWH)"
_FAULT_PAGE = re.compile(r"fault\d\d")
_NUMBERED = re.compile(r"(\D+)(\d+)")

_MAIN = {
    "temp": "TEMPERATURE",
    "set": "SETPOINT",
    "duty": "DUTY",
    "on": "ENABLED",
    "state": "STATE",
    "ERROR": "ALARM",
    "alarm": "ALARM_WORD",
    "energy": "ENERGY",
    "bt1": "ON_THE_WAY",
    "programm": "PROGRAM",
    "point": "SEGMENT",
    "pname": "NAME",
    "day": "DAYS",
    "hour1": "HOURS",
    "minute1": "MINUTES",
    "day2": "SEGMENT_DAYS",
    "hour2": "SEGMENT_HOURS",
    "minute2": "SEGMENT_MINUTES",
}
_POINTS = {
    "programm": "PROGRAM",
    "pname": "NAME",
    "p": "COLOUR",
    "k": "KIND",
    "m": "TIME_OR_RATE",
    "t": "TARGET",
}
_DEBUG = {
    "ot": "DUTY",
    "t": "EXACT_TEMPERATURE",
    "sp": "EXACT_SETPOINT",
    "on": "ENABLED",
    "kp": "KP",
    "ki": "KI",
    "kd": "KD",
    "settled": "SETTLING",
    "over": "OVERSHOOT",
}
_SHOWN = {
    "main": _MAIN,
    "programs": {"name": "PLACE"},
    "points": _POINTS,
    "points2": _POINTS,
    "settings": {"sp": "ASKED_SETPOINT", "crit": "MAXIMUM", "type": "TYPE", "saves": "SAVES"},
    "debug": _DEBUG,
    "thermo": {"type": "TYPE"},
    "faults": {"l": "LISTED"},
    "fault": {"t": "FAULT_TEMPERATURE"},
}
"""Contents by page and component; a component of a row has the row's number behind its name."""


def whats(source: Source, interface: Nextion) -> list[What]:
    """List the contents on the pages of this controller, each once."""
    known = _known(source, interface)
    used = {each.what for _, rows in _by_page(source, known) for each in rows}
    return [what for what in known if what.macro in used]


def components(source: Source, shown: list[What]) -> tuple[list[Shows], list[Begin]]:
    """List the components, and where pages begin."""
    found: list[Shows] = []
    begins: list[Begin] = []
    for name, rows in _by_page(source, shown):
        begins.append(Begin(name, len(found), len(rows)))
        found += rows
    return found, begins


def _known(source: Source, interface: Nextion) -> list[What]:
    """List all contents; a machine without programs has fewer."""
    known = [*_control(source, interface), *_settings(source, interface)]
    if facts_of(source.controller, interface.loop).programmed:
        known += _program()
        heater = source.controller.outputs[source.controller.loops[interface.loop].heater]
        if heater.power_w is not None:
            known.append(What("SHOWS_ENERGY", "AS_ENERGY", ENERGY))
    return known


def _by_page(source: Source, known: list[What]) -> Iterable[tuple[str, list[Shows]]]:
    """Return each page with its components that have a content; all fault pages are alike."""
    macros = {what.macro for what in known}
    faults_are_done = False
    for page in display_pages(source.controller):
        of_fault = _FAULT_PAGE.fullmatch(page.name) is not None
        if of_fault and faults_are_done:
            continue
        faults_are_done |= of_fault
        rows = [row for row in _of_page(page, of_fault=of_fault) if row.what in macros]
        yield ("every fault" if of_fault else page.name), rows


def _of_page(page: Page, *, of_fault: bool) -> Iterable[Shows]:
    shown = _SHOWN.get("fault" if of_fault else page.name, {})
    for component in page.components:
        stem, row = component.name, 0
        numbered = _NUMBERED.fullmatch(stem)
        if stem not in shown and numbered:
            stem, row = numbered[1], int(numbered[2])
        if stem in shown and (row or component.name == stem):
            prefix = "" if of_fault else f"{page.name}."
            yield Shows(f"{prefix}{stem}", row, f"SHOWS_{shown[stem]}")


def _control(source: Source, interface: Nextion) -> list[What]:
    loop = f"loop_{interface.loop}"
    alarm = "alarm_word()" if source.controller.monitors else "WORD_OF_FAULTS + fault.code"
    return [
        What("SHOWS_TEMPERATURE", "AS_NUMBER", f"steps({loop}.temperature_c, 1.0f)"),
        What("SHOWS_EXACT_TEMPERATURE", "AS_TENTHS", f"tenths({loop}.temperature_c)"),
        What("SHOWS_SETPOINT", "AS_NUMBER", f"steps({loop}.setpoint_c, 1.0f)"),
        What("SHOWS_EXACT_SETPOINT", "AS_TENTHS", f"tenths({loop}.setpoint_c)"),
        What("SHOWS_DUTY", "AS_NUMBER", f"steps({loop}.duty_percent, 1.0f)"),
        What("SHOWS_ENABLED", "AS_NUMBER", f"{loop}.enabled"),
        What("SHOWS_STATE", "AS_WORD", "state_word()"),
        What("SHOWS_ALARM", "AS_SWITCH", "fault.code != FAULT_NONE"),
        What("SHOWS_ALARM_WORD", "AS_WORD", alarm),
        What("SHOWS_FAULT_TEMPERATURE", "AS_TENTHS", "tenths(fault.temperature_c)"),
        What("SHOWS_LISTED", "AS_LISTED", "fault_log_count()"),
    ]


def _settings(source: Source, interface: Nextion) -> list[What]:
    name, facts = interface.loop, facts_of(source.controller, interface.loop)
    found = [What("SHOWS_ASKED_SETPOINT", "AS_TENTHS", f"tenths(settings.{name}_setpoint_c)")]
    if facts.tunable:
        found += [
            What(f"SHOWS_{gain.upper()}", "AS_FLOAT", f"bits(settings.{name}_{gain})")
            for gain in ("kp", "ki", "kd")
        ]
    if facts.response:
        response = f"response_{name}"
        found += [
            What("SHOWS_SETTLING", "AS_NUMBER", f"steps({response}.settling_s, 1.0f)"),
            What("SHOWS_OVERSHOOT", "AS_TENTHS", f"tenths({response}.overshoot_k)"),
        ]
    if facts.adjustable:
        found.append(What("SHOWS_MAXIMUM", "AS_TENTHS", f"tenths(settings.{name}_maximum_c)"))
    if selectable_types(source.controller):
        type_code = f"settings.{facts.sensor}_thermocouple"
        found.append(What("SHOWS_TYPE", "AS_LETTER", f"type_letter({type_code})"))
    return found


def _program() -> list[What]:
    program = "read_clock(&program_clock, program.clock)->"
    segment = "read_clock(&segment_clock, program.segment_clock)->"
    return [
        What("SHOWS_SAVES", "AS_NUMBER", "(int32_t)progress_saves()"),
        What("SHOWS_ON_THE_WAY", "AS_NUMBER", "is_on_the_way()"),
        What("SHOWS_PROGRAM", "AS_NUMBER", "points_number"),
        What("SHOWS_SEGMENT", "AS_NUMBER", "program.segment"),
        What("SHOWS_NAME", "AS_NAME", "points_revision"),
        What("SHOWS_PLACE", "AS_PLACE", "points_revision"),
        What("SHOWS_DAYS", "AS_NUMBER", f"{program}days"),
        What("SHOWS_HOURS", "AS_NUMBER", f"{program}hours"),
        What("SHOWS_MINUTES", "AS_NUMBER", f"{program}minutes"),
        What("SHOWS_SEGMENT_DAYS", "AS_NUMBER", f"{segment}days"),
        What("SHOWS_SEGMENT_HOURS", "AS_NUMBER", f"{segment}hours"),
        What("SHOWS_SEGMENT_MINUTES", "AS_NUMBER", f"{segment}minutes"),
        What("SHOWS_COLOUR", "AS_COLOUR", "colour(row)"),
        What("SHOWS_KIND", "AS_WORD", "WORD_OF_KINDS + segment(row)->kind"),
        What("SHOWS_TIME_OR_RATE", "AS_TIME_OR_RATE", "amount(row)"),
        What("SHOWS_TARGET", "AS_TARGET", "target(row)"),
    ]
