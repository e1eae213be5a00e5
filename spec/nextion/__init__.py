"""The pages of a Nextion display as data, both for the editor's script and for the simulation.

`display_pages` lists them for a controller; a page's number is its place in the list. The firmware
sets the components of the page that is shown; a touch executes code of the component.
"""

import math
from functools import lru_cache

from heatwright.spec.controller import Controller
from heatwright.spec.facts import facts_of
from heatwright.spec.loops import Loop
from heatwright.spec.nextion.control import (
    debug_page,
    fault_page,
    faults_page,
    settings_page,
    thermo_page,
)
from heatwright.spec.nextion.keypads import name_page, number_page, point_page
from heatwright.spec.nextion.overview import main_page, stop_page
from heatwright.spec.nextion.parts import FONTS, HEIGHT, WIDTH, Component, Page
from heatwright.spec.nextion.programming import ROWS, points_page, programs_page
from heatwright.spec.sensing.max31856 import HIGHEST_C, lowered


@lru_cache(maxsize=8)
def display_pages(controller: Controller) -> tuple[Page, ...]:
    """Lay out all pages of the display of a controller that has one."""
    facts = facts_of(controller)
    if facts.nextion is None:
        return ()
    top_c, loop = chart_top_c(controller), facts.loops[facts.nextion.loop]
    programs = controller.programs if loop.programmed else None
    types = selectable_types(controller)
    pages = [main_page(0, top_c, programs=programs is not None), stop_page(1)]
    if programs is not None:
        pages += [programs_page(2, programs.places)]
        second = "points2" if programs.points > ROWS else ""
        pages += [points_page(3, 1, programs.points, more=second), point_page(4), name_page(5)]
        if second:
            pages += [points_page(6, ROWS + 1, programs.points, more="points")]
    first = len(pages)
    pages += [
        settings_page(
            first, adjustable=loop.adjustable, selectable=bool(types), saves=programs is not None
        ),
        debug_page(first + 1, top_c, tunable=loop.tunable, measured=loop.response),
        number_page(first + 2, ((first, "settings"), (first + 1, "debug"))),
    ]
    if types:
        pages += [thermo_page(len(pages), _highest_c(controller.loops[loop.name], controller))]
    pages += [faults_page(len(pages))]
    first = len(pages)
    pages += [fault_page(first + place, rule) for place, rule in enumerate(facts.rules)]
    return tuple(pages)


def chart_top_c(controller: Controller) -> int:
    """The temperature at the upper edge of the charts, °C: the maximum, in whole hundreds."""
    display = facts_of(controller).nextion
    assert display is not None  # noqa: S101 - only a display has charts
    return math.ceil(controller.loops[display.loop].protection.maximum_c / 100) * 100


def _highest_c(loop: Loop, controller: Controller) -> dict[str, float]:
    """Return the highest setpoint that each selectable type allows, °C."""
    sensor = controller.thermometers[loop.sensor]
    less = lowered(sensor, loop.setpoint.maximum_c, loop.protection.maximum_c)
    return {kind: less.get(kind, HIGHEST_C[kind]) for kind in sensor.selectable}


def selectable_types(controller: Controller) -> tuple[str, ...]:
    """Types of the thermocouple that the operator may choose; none if there is only one."""
    display = facts_of(controller).nextion
    if display is None:
        return ()
    return controller.thermometers[controller.loops[display.loop].sensor].selectable
