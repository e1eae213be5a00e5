"""The page that is shown most: temperature, program, clocks, chart; and the question before a stop.

The components have the names of an older display that this one copies: temp, day, hour1, minute1,
day2, hour2, minute2, programm, point, ERROR, bt1, and 24 as the number of the chart.
"""

from dataclasses import replace

from heatwright.spec.nextion.parts import (
    AMBER,
    GRID,
    GROUND,
    HUGE,
    LARGE,
    LIME,
    RED,
    SMALL,
    Page,
    Sheet,
)
from heatwright.spec.programs import LONGEST_NAME

CHART_PX = (600, 180)
"""The chart's width and height; its values are sent to the display as heights in pixels."""
CHART_EVERY_S = 60.0
"""Time between two pixels: ten hours in the chart's width."""
LONGEST_STATE = 30
LONGEST_ENERGY = 12
"""Maximum number of characters of an energy, such as `1234.56 kWh`."""


def main_page(number: int, top_c: int, *, programs: bool) -> Page:
    """Lay out the main page. top_c -- the temperature at the chart's upper edge, °C."""
    sheet = Sheet("main", number, "What the machine is doing.")
    sheet.number("temp", (10, 8, 210, 90), HUGE, pco=AMBER)
    sheet.number("set", (275, 48, 130, 50), pco=LIME)
    if programs:
        _clocks(sheet)
    _state(sheet, programs=programs)
    _orders(sheet, programs=programs)
    sheet.text("energy", (330, 420, 190, 40), LONGEST_ENERGY)
    sheet.number("duty", (150, 420, 70, 40), SMALL)
    sheet.add("waveform", "chart", (70, 200, *CHART_PX), waveform_attributes())
    _labels(sheet, top_c, programs=programs)
    _flash(sheet)
    return sheet.page(preinitialize=("ERROR.en=0",))


def stop_page(number: int) -> Page:
    """Lay out the question before a stop."""
    sheet = Sheet("stop", number, "Asks before it stops.")
    sheet.label("ask", (200, 120, 400, 60), "Stop and switch off?", LARGE)
    sheet.button("yes", (140, 240, 220, 90), "Stop", ('print "#17;"', "page main"), RED)
    sheet.button("no", (440, 240, 220, 90), "Back", ("page main",))
    return sheet.page()


def waveform_attributes() -> dict[str, int]:
    """Attributes of a chart: temperature, setpoint behind it, and a line each 60 pixels."""
    return {
        "ch": 2, "bco": GROUND, "gdc": GRID, "gdw": 60, "gdh": 60, "dis": 100,
        "pco0": AMBER, "pco1": LIME,
    }  # fmt: skip


def _clocks(sheet: Sheet) -> None:
    """Add the elapsed times of program and segment, and the names of both."""
    places = {"day": 470, "hour1": 526, "minute1": 582}
    for name, x in places.items():
        sheet.number(name, (x, 52, 50, 36), SMALL)
    for name, x in zip(("day2", "hour2", "minute2"), places.values(), strict=True):
        sheet.number(name, (x, 146, 50, 36), SMALL)
    sheet.number("programm", (446, 8, 40, 38), SMALL)
    sheet.number("point", (446, 102, 40, 38), SMALL)
    sheet.text("pname", (492, 8, 184, 38), LONGEST_NAME, shared=True)


def _state(sheet: Sheet, *, programs: bool) -> None:
    sheet.text("state", (10, 106, 395, 38), LONGEST_STATE, shared=True)
    switch = "bt1" if programs else "on"
    command, text = ("#9", "run") if programs else ("#2", "on")
    code = switched(switch, command)
    sheet.switch(switch, _column(0), text, code, longest=4, shared=True)
    sheet.add("timer", "ERROR", attributes={"tim": 500, "en": 0}, shared=True)
    sheet.text("alarm", (10, 150, 395, 38), LONGEST_STATE, release=('print "#12;"',))
    sheet.variable("flash")


def switched(name: str, command: str) -> tuple[str, ...]:
    """Return code that sends 1 or 0, the state of a two-state button after the touch."""
    return (
        f"if({name}.val==1)", "{", f'print "{command} 1;"', "}else", "{", f'print "{command} 0;"',
        "}",
    )  # fmt: skip


def _orders(sheet: Sheet, *, programs: bool) -> None:
    sheet.button("bstop", _column(1), "stop", ("page stop",), RED)
    if programs:
        sheet.button("bskip", _column(2), "go on", ('print "#18;"',))
        sheet.button("bprog", _column(3), "programs", ("page programs",))
    sheet.button("bset", _column(4), "settings", ("page settings",))
    sheet.button("bdebug", _column(5), "control", ("page debug",))


def _labels(sheet: Sheet, top_c: int, *, programs: bool) -> None:
    """Add the components after the chart, whose number must not depend on them."""
    sheet.button("bfaults", _column(6), "faults", ('print "#12;"',))
    sheet.label("lset", (275, 8, 130, 38), "setpoint")
    sheet.label("lc", (225, 55, 40, 38), "°C")
    sheet.label("lduty", (70, 420, 75, 40), "power")
    sheet.label("lpercent", (225, 420, 30, 40), "%")
    sheet.label("ltop", (8, 196, 60, 28), f"{top_c}")
    sheet.label("lbottom", (8, 356, 60, 28), "0")
    sheet.label("lspan", (600, 384, 75, 30), f"{CHART_PX[0] * CHART_EVERY_S / 3600:.0f} h")
    if programs:
        sheet.button("bpoints", (492, 102, 184, 38), "segments", ("page points",))
        sheet.label("lclock", (638, 52, 48, 36), "dhm")
        sheet.label("lclock2", (638, 146, 48, 36), "dhm")
        sheet.label("lprog", (420, 8, 24, 38), "P")
        sheet.label("lpoint", (420, 102, 24, 38), "S")


def _flash(sheet: Sheet) -> None:
    """Let the timer ERROR flash the whole page: its background, and that of the components on it.

    The page's background changes last, because the display then redraws everything. Opening the
    page stops the timer, until the board reports the fault again.
    """
    on_ground = [each.name for each in sheet.components if each.attributes.get("bco") == GROUND]
    code = (
        f"if(main.bco=={GROUND})", "{", f"flash.val={RED}", "}else", "{", f"flash.val={GROUND}",
        "}", *(f"{name}.bco=flash.val" for name in (*on_ground, sheet.name)),
    )  # fmt: skip
    sheet.components = [
        replace(each, timer=code) if each.name == "ERROR" else each for each in sheet.components
    ]


def _column(place: int) -> tuple[int, int, int, int]:
    """Place of a button in the column at the right."""
    return 690, 8 + 67 * place, 102, 60
