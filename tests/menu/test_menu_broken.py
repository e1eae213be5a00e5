"""Lines of the menu that stand between a key and a heater: broken, each is noticed."""

from pathlib import Path

import pytest
from menu_desk import MenuDesk
from whole_firmware import Broken, whole

from heatwright.spec import load

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "kiln_uno.yaml"
IDLE = 0


def starts_at_once(desk: MenuDesk) -> bool:
    """Whether one SELECT starts a program."""
    desk.press("right", "right", "select")
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def starts_after_another_key(desk: MenuDesk) -> bool:
    """Whether a SELECT counts as the second one though another key came between."""
    desk.press("right", "right", "select", "up", "down", "select")
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def starts_after_leaving(desk: MenuDesk) -> bool:
    """Whether a SELECT counts as the second one though the screen was left between."""
    desk.press("right", "right", "select", "left", "right", "select")
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def starts_what_was_to_end(desk: MenuDesk) -> bool:
    """Whether the second SELECT of "skip" starts a program when the first one has ended."""
    desk.press("right", "right", "select", "select")
    desk.run(1.2)
    desk.press("up", "select")
    state = desk.device.variables["program.state"]
    desk.device.avr.write_ram(state.address, bytes([IDLE]))
    desk.press("select")
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def starts_before_it_is_saved(desk: MenuDesk) -> bool:
    """Whether a program that was just changed is started as it was before."""
    desk.press("right", "right", "right", "select", "select", "right", "up", "select")
    for key in ("select", "left", "select", "select"):
        desk.device.press(key)
        desk.run(0.03)
        desk.device.press(None)
        desk.run(0.03)
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def repeats_select(desk: MenuDesk) -> bool:
    """Whether a SELECT that is held counts again."""
    desk.press("right", "right")
    desk.hold("select", 3.0)
    desk.run(1.2)
    return bool(desk.program("state") != IDLE)


def switches_on_at_once(desk: MenuDesk) -> bool:
    """Whether UP alone switches the loop on."""
    desk.press("left", "select", "up")
    desk.run(1.2)
    return bool(desk.device.read("loop_chamber.enabled"))


def works_with_a_fault(desk: MenuDesk) -> bool:
    """Whether keys change anything while a fault is latched."""
    desk.press("left")
    desk.device.sensors["chamber"].unplug()
    desk.run(7.0)
    desk.press("up")
    return bool(desk.device.read("settings.chamber_setpoint_c") != desk.felt_c)


BROKEN = {
    "one select": (
        Broken(
            "menu_run.c",
            "if (asked != meant && (idle || choice != PAUSE_OR_RESUME)) {",
            "if (asked != meant && choice != PAUSE_OR_RESUME) {",
        ),
        starts_at_once,
    ),
    "another key between": (
        Broken(
            "menu_run.c",
            "    asked = NOTHING;\n    refused = false;\n    if (up) {",
            "    refused = false;\n    if (up) {",
        ),
        starts_after_another_key,
    ),
    "another screen between": (
        Broken(
            "menu_run.c",
            "        asked = NOTHING;\n        refused = false;\n        choice",
            "        refused = false;\n        choice",
        ),
        starts_after_leaving,
    ),
    "meant otherwise": (
        Broken("menu_run.c", "idle ? TO_START : TO_DO;", "TO_START;"),
        starts_what_was_to_end,
    ),
    "not saved yet": (
        Broken("menu_run.c", "programs_are_saved() && ", ""),
        starts_before_it_is_saved,
    ),
    "select repeats": (
        Broken(
            "panel.c",
            "keypad_repeats() != 0 && key != KEY_UP",
            "key == KEY_NONE && key != KEY_UP",
        ),
        repeats_select,
    ),
    "on at once": (
        Broken(
            "menu_values.c",
            "changed = !loop_chamber_is_enabled();",
            "(void)loop_chamber_enable();",
        ),
        switches_on_at_once,
    ),
    "keys in a fault": (
        Broken(
            "panel.c",
            "            fault_acknowledge();\n        }\n        return;",
            "            fault_acknowledge();\n        }",
        ),
        works_with_a_fault,
    ),
}


def made(broken: Broken | None) -> MenuDesk:
    desk = MenuDesk(load(EXAMPLE).controller, whole(EXAMPLE.read_text(encoding="utf-8"), broken))
    desk.run(2.5)
    return desk


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_line_is_noticed(name: str) -> None:
    broken, does_harm = BROKEN[name]
    assert does_harm(made(broken))


@pytest.mark.parametrize("name", BROKEN)
def test_the_sound_menu_does_no_harm(desk: MenuDesk, name: str) -> None:
    assert not BROKEN[name][1](desk)
