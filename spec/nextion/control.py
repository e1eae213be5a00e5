"""The pages of settings, of the thermocouple's type, of the control itself, and of the faults."""

import math
from collections.abc import Mapping

from heatwright.spec.nextion.keypads import asking
from heatwright.spec.nextion.overview import switched, waveform_attributes
from heatwright.spec.nextion.parts import AMBER, GREEN, LARGE, RED, Page, Sheet
from heatwright.spec.nextion.programming import LONGEST_NUMBER
from heatwright.spec.rules import Rule
from heatwright.spec.sensing.max31856 import TYPE_CODES

CONTROL_CHART_PX = (800, 180)
"""Width and height: at one pixel a second the chart shows 800 s."""
CONTROL_CHART_EVERY_S = 1.0

LISTED = 8
"""Maximum number of faults that the page of faults lists."""
LONGEST_FAULT = 40


def settings_page(number: int, *, adjustable: bool, selectable: bool, saves: bool) -> Page:
    """Lay out the operator's settings: setpoint, critical temperature, type of the thermocouple."""
    sheet = Sheet("settings", number, "Setpoint, critical temperature, thermocouple.")
    sheet.label("title", (10, 5, 400, 40), "Settings", LARGE)
    rows = [("sp", "Setpoint °C", asking(3, "Setpoint", "sp", number))]
    if adjustable:
        rows += [("crit", "Critical °C", asking(20, "Critical temperature", "crit", number))]
    if selectable:
        rows += [("type", "Thermocouple", ("page thermo",))]
    for row, (name, title, code) in enumerate(rows):
        y = 70 + 70 * row
        sheet.text(name, (300, y, 200, 55), LONGEST_NUMBER, LARGE, pco=AMBER)
        sheet.label(f"l{name}", (10, y, 280, 55), title, LARGE)
        sheet.button(f"b{name}", (520, y, 150, 55), "change", code)
    if saves:
        sheet.number("saves", (300, 280, 200, 55))
        sheet.label("lsaves", (10, 280, 280, 55), "Notes of progress", LARGE)
    sheet.button("back", (690, 420, 100, 55), "back", ("page main",))
    return sheet.page()


def thermo_page(number: int, highest_c: Mapping[str, float]) -> Page:
    """Lay out the choice of the thermocouple's type: each with the highest setpoint it allows."""
    sheet = Sheet("thermo", number, "Choice of the thermocouple's type.")
    sheet.text("type", (300, 5, 60, 50), 1, LARGE, pco=AMBER)
    sheet.label("title", (10, 5, 280, 50), "Thermocouple", LARGE)
    for place, letter in enumerate(sorted(highest_c)):
        x, y = 10 + 195 * (place % 4), 90 + 110 * (place // 4)
        code = (f'print "#15 {TYPE_CODES.index(letter)};"',)
        text = f"{letter}  {math.floor(highest_c[letter])} °C"
        sheet.button(f"type{letter}", (x, y, 180, 90), text, code)
    sheet.label("only", (10, 340, 600, 40), "Only while no program runs and the heater is off.")
    sheet.button("back", (690, 420, 100, 55), "back", ("page settings",))
    return sheet.page()


def debug_page(number: int, top_c: int, *, tunable: bool, measured: bool) -> Page:
    """Lay out the page for tuning: gains, on and off, the running chart."""
    sheet = Sheet("debug", number, "The control: gains, on and off, running chart.")
    sheet.number("ot", (90, 10, 100, 40))
    sheet.text("kp", (64, 60, 130, 40), LONGEST_NUMBER, pco=AMBER)
    sheet.text("ki", (64, 105, 130, 40), LONGEST_NUMBER, pco=AMBER)
    sheet.text("kd", (64, 150, 130, 40), LONGEST_NUMBER, pco=AMBER)
    sheet.text("t", (330, 10, 130, 40), LONGEST_NUMBER)
    sheet.text("sp", (330, 60, 130, 40), LONGEST_NUMBER)
    sheet.add("waveform", "chart", (0, 240, *CONTROL_CHART_PX), waveform_attributes())
    sheet.switch("on", (560, 10, 110, 60), "on", switched("on", "#2"), longest=2)
    sheet.label("lt", (260, 10, 60, 40), "T °C")
    sheet.label("lsp", (260, 60, 60, 40), "set")
    sheet.label("lot", (10, 10, 70, 40), "out %")
    if measured:  # added after the chart, whose number must not change
        sheet.number("settled", (380, 110, 120, 40))
        sheet.text("over", (380, 160, 120, 40), LONGEST_NUMBER)
        sheet.label("lsettled", (260, 110, 110, 40), "settled s")
        sheet.label("lover", (260, 160, 110, 40), "over K")
    sheet.label("ltop", (0, 210, 120, 28), f"{top_c} °C")
    if tunable:
        sheet.button("bot", (200, 10, 50, 40), "=", asking(4, "Output in percent", "zero", number))
        sheet.words("zero", 1)
        for command, name, y in ((5, "kp", 60), (6, "ki", 105), (19, "kd", 150)):
            title = name.capitalize()
            sheet.button(f"b{name}", (200, y, 50, 40), "=", asking(command, title, name, number))
            sheet.label(f"l{name}", (10, y, 50, 40), title)
        sheet.button("keep", (560, 80, 110, 60), "keep", ('print "#22;"',), GREEN)
    sheet.button("back", (690, 10, 100, 60), "back", ("page main",))
    return sheet.page()


def faults_page(number: int) -> Page:
    """Lay out the list of faults since the reset, the newest first."""
    sheet = Sheet("faults", number, "The last faults since the reset, the newest first.")
    for place in range(1, LISTED + 1):
        sheet.text(f"l{place}", (10, 52 + 44 * (place - 1), 660, 40), LONGEST_FAULT)
    sheet.label("title", (10, 5, 400, 40), "Faults", LARGE)
    sheet.button("ack", (690, 60, 100, 60), "seen", ('print "#16;"',), GREEN)
    sheet.button("back", (690, 420, 100, 55), "back", ("page main",))
    return sheet.page()


def fault_page(number: int, rule: Rule) -> Page:
    """Lay out the page of one fault: its meaning, the temperature, the remedy."""
    sheet = Sheet(f"fault{rule.code:02d}", number, rule.meaning)
    sheet.text("t", (10, 230, 200, 50), LONGEST_NUMBER, LARGE, pco=AMBER)
    sheet.label("code", (0, 0, 800, 66), f"E{rule.code:02d} {rule.display}", LARGE, bco=RED)
    sheet.label("means", (10, 80, 780, 60), rule.meaning)
    sheet.label("remedy", (10, 150, 780, 60), rule.remedy)
    sheet.label("lt", (220, 230, 60, 50), "°C")
    sheet.button("ack", (10, 340, 220, 90), "seen", ('print "#16;"',), GREEN)
    sheet.button("list", (280, 340, 220, 90), "all faults", ('print "#12;"',))
    sheet.button("back", (550, 340, 220, 90), "back", ("page main",))
    return sheet.page()
