"""The page that is shown most: temperature, program, clocks, chart; and the question before a stop.

The names are those of the display this one takes after: temp, day, hour1, minute1, day2, hour2,
minute2, programm, point, ERROR, bt1, and 24 as the number of the chart.
"""

from __future__ import annotations

from heatwright.spec.nextion.parts import (
    AMBER,
    BLACK,
    DARK,
    GREEN,
    GREY,
    HUGE,
    LARGE,
    RED,
    SMALL,
    WHITE,
    Page,
    Sheet,
    text_attributes,
)
from heatwright.spec.programs import LONGEST_NAME

CHART_PX = (360, 180)
"""The chart's width and height; a value is a height in pixels."""
CHART_EVERY_S = 90.0
"""Time between two pixels: nine hours in the chart's width."""
LONGEST_STATE = 30
LONGEST_ENERGY = 12
"""Such as `1234.56 kWh`."""

FLASHING = (
    "if(flash.val==0)",
    "{",
    "flash.val=1",
    f"alarm.bco={RED}",
    "}else",
    "{",
    "flash.val=0",
    f"alarm.bco={BLACK}",
    "}",
)
"""What the timer ERROR does: it has `alarm` flash."""


def main_page(number: int, top_c: int, *, programs: bool) -> Page:
    """Lay the main page out. top_c -- the temperature at the chart's upper edge, °C."""
    sheet = Sheet("main", number, "What the machine is doing.")
    sheet.number("temp", (10, 10, 200, 90), HUGE)
    sheet.number("set", (330, 30, 110, 50))
    if programs:
        _clocks(sheet)
    _state(sheet, programs=programs)
    _orders(sheet, programs=programs)
    sheet.text("energy", (470, 205, 200, 40), LONGEST_ENERGY)
    sheet.number("duty", (10, 390, 60, 40), SMALL)
    sheet.add("waveform", "chart", (70, 200, *CHART_PX), waveform_attributes())
    _labels(sheet, top_c, programs=programs)
    return sheet.page()


def stop_page(number: int) -> Page:
    """Lay out the question before a stop."""
    sheet = Sheet("stop", number, "Asks before it stops.")
    sheet.label("ask", (200, 120, 400, 60), "Stop and switch off?", LARGE)
    sheet.button("yes", (140, 240, 220, 90), "Stop", ('print "#17;"', "page main"), RED)
    sheet.button("no", (440, 240, 220, 90), "Back", ("page main",))
    return sheet.page()


def waveform_attributes() -> dict[str, int]:
    """Two channels: the temperature, and the setpoint behind it; a line each 60 pixels."""
    return {
        "ch": 2, "bco": BLACK, "gdc": GREY, "gdw": 60, "gdh": 60, "dis": 100,
        "pco0": AMBER, "pco1": GREEN,
    }  # fmt: skip


def _clocks(sheet: Sheet) -> None:
    """Time in the program and in the segment, and which they are."""
    places = {"day": 470, "hour1": 530, "minute1": 590}
    for name, x in places.items():
        sheet.number(name, (x, 105, 50, 40), SMALL)
    for name, x in zip(("day2", "hour2", "minute2"), places.values(), strict=True):
        sheet.number(name, (x, 155, 50, 40), SMALL)
    sheet.number("programm", (470, 10, 40, 40), SMALL)
    sheet.number("point", (470, 55, 40, 40), SMALL)
    sheet.text("pname", (520, 10, 150, 40), LONGEST_NAME, shared=True)


def _state(sheet: Sheet, *, programs: bool) -> None:
    sheet.text("state", (10, 110, 430, 40), LONGEST_STATE, LARGE, shared=True, pco=AMBER)
    switch = "bt1" if programs else "on"
    command, text = ("#9", "run") if programs else ("#2", "on")
    sheet.add(
        "dual_state", switch, (690, 10, 100, 60),
        text_attributes(text, 4, SMALL) | {"val": 0, "bco": DARK, "bco2": GREEN, "xcen": 1},
        release=switched(switch, command), shared=True,
    )  # fmt: skip
    sheet.add("timer", "ERROR", attributes={"tim": 500, "en": 0}, timer=FLASHING, shared=True)
    sheet.text("alarm", (10, 155, 430, 40), LONGEST_STATE, release=('print "#12;"',), pco=WHITE)
    sheet.variable("flash")


def switched(name: str, command: str) -> tuple[str, ...]:
    """Order 1 or 0, as a button of two states stands after the touch."""
    return (
        f"if({name}.val==1)", "{", f'print "{command} 1;"', "}else", "{", f'print "{command} 0;"',
        "}",
    )  # fmt: skip


def _orders(sheet: Sheet, *, programs: bool) -> None:
    sheet.button("bstop", (690, 80, 100, 60), "stop", ("page stop",), RED)
    if programs:
        sheet.button("bskip", (690, 150, 100, 60), "go on", ('print "#18;"',))
        sheet.button("bprog", (690, 220, 100, 60), "programs", ("page programs",))
    sheet.button("bset", (690, 290, 100, 60), "settings", ("page settings",))
    sheet.button("bdebug", (690, 360, 100, 60), "control", ("page debug",))


def _labels(sheet: Sheet, top_c: int, *, programs: bool) -> None:
    """What comes behind the chart, so that its number does not depend on it."""
    sheet.button("bfaults", (690, 430, 100, 45), "faults", ('print "#12;"',))
    sheet.label("lset", (220, 30, 110, 50), "°C  set")
    sheet.label("lduty", (10, 430, 60, 40), "%")
    sheet.label("ltop", (10, 200, 60, 30), f"{top_c}")
    sheet.label("lspan", (70, 390, 360, 30), "9 h")
    if programs:
        sheet.button("bpoints", (520, 55, 150, 45), "segments", ("page points",))
        sheet.label("lclock", (650, 105, 40, 40), "d h m")
        sheet.label("lclock2", (650, 155, 40, 40), "d h m")
        sheet.label("lprog", (450, 10, 20, 40), "P")
        sheet.label("lpoint", (450, 55, 20, 40), "S")
