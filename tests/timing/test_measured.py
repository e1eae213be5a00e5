"""The chamber's binary keeps its times, and one made worse does not pass."""

from pathlib import Path

import pytest
from rig.firmware import changed, sources_of, spec_of, whole

from heatwright.sim.timing import Timing, measure
from heatwright.spec import Controller

KEYPAD = "  - {kind: lcd_keypad, loop: air, step: 10 K}\n"
SHORT_US = 20.0  # with interrupts off, in a machine of one loop at 16 MHz
CURRENT = (
    "current: {kind: current, pin: PA1, scale: 0.5 V/A, oversample: 4, "
    "tolerances: {scale: 2 %, offset: 10 mV, reference: 0.2 V}}"
)
BLOWER = "kind: digital, pin: PC7, runs: always, proof: {pin: PC6, within: 3 s}"
PRESSES = "    - {at: 10 s, press: up, times: 3}\n"


@pytest.fixture(scope="module")
def timing(chamber: Controller, chamber_elf: Path) -> Timing:
    return measure(chamber, chamber_elf, static_stack_bytes=1000)


def failed(timing: Timing) -> set[str]:
    assert timing.passed is not any(not each.passed for each in timing.figures.values())
    return {name for name, figure in timing.figures.items() if not figure.passed}


def test_the_chamber_keeps_its_times(timing: Timing) -> None:
    assert failed(timing) == set()
    assert set(timing.figures) == {
        "button_to_display_ms", "step_jitter_us", "longest_busy_wait_us",
        "longest_interrupts_off_us", "longest_one_wire_slot_us", "longest_tick_us",
        "stack_used_bytes",
    }  # fmt: skip
    found = timing.as_json()
    assert found["passed"] is True
    for name, figure in timing.figures.items():
        due = {"worst": figure.worst, "limit": figure.limit, "passed": True}
        assert due.items() <= found[name].items()


def test_what_was_measured_is_no_accident(timing: Timing) -> None:
    key, step = (timing.figures[each] for each in ("button_to_display_ms", "step_jitter_us"))
    assert key.details["presses"] >= 60
    assert key.details["not_shown"] == 0
    assert key.worst is not None
    assert 20 < key.details["median"] < key.worst, "debouncing alone takes two ticks"
    assert step.details["steps"] >= 60
    assert step.worst is not None
    assert step.worst > 0
    assert timing.figures["longest_tick_us"].details["ticks"] >= 59_990
    assert timing.figures["longest_tick_us"].limit == pytest.approx(10_000)
    assert timing.figures["longest_one_wire_slot_us"].where == "__vector_7 (one_wire_air.c)"
    masked_us = timing.figures["longest_interrupts_off_us"].worst
    assert masked_us is not None
    assert masked_us < SHORT_US, "it has one loop, and nothing at the heater's gate but a fan"
    assert 0.9 < timing.idle_fraction < 1
    cycles = [each.longest for each in timing.functions]
    assert (len(cycles), cycles) == (10, sorted(cycles, reverse=True))


def test_more_stack_than_the_code_explains(chamber: Controller, chamber_elf: Path) -> None:
    assert failed(measure(chamber, chamber_elf, static_stack_bytes=40)) == {"stack_used_bytes"}


Change = tuple[str, str]
MASKED = "case KEY_UP:\n cli(); _delay_us(60); sei();\n"
HEADERS = '#include "panel.h"\n#include <avr/interrupt.h>\n#include <util/delay.h>\n'
WORSE: dict[str, tuple[str, list[Change], str]] = {
    "a busy wait": (
        "lcd.c", [("EXECUTION_US = 40", "EXECUTION_US = 150")], "longest_busy_wait_us"),
    "interrupts off": (
        "panel.c",
        [('#include "panel.h"\n', HEADERS),
         ("case KEY_UP:\n", MASKED)],
        "longest_interrupts_off_us"),
    "a loop that loses ticks": (
        "loop_air.c",
        [("    ticks_left = LOOP_AIR_PERIOD_TICKS;\n    step();",
          "ticks_left = (uint16_t)(LOOP_AIR_PERIOD_TICKS + ((loop_air.steps & 63u) == 0)); step();"
          )],
        "step_jitter_us"),
    "a display that sends one cell a tick, the temperature first": (
        "lcd.c",
        [("position = LCD_COLUMNS - 1u;", "position = LCD_CELLS - 1u;"),
         ("CELLS_A_TICK = 6", "CELLS_A_TICK = 1")],
        "button_to_display_ms"),
    "a display that is set up again slowly": (
        "lcd.c", [("        if (!is_set_up) {", "        if (true) {")], "button_to_display_ms"),
    "a key that is shown with the next step": (
        "panel.c",
        [("        break;\n    }\n    show_setpoint_or_fault();\n}", "        break;\n    }\n}")],
        "button_to_display_ms"),
}  # fmt: skip


@pytest.mark.parametrize("what", WORSE)
def test_a_firmware_made_worse_does_not_pass(what: str, chamber: Controller) -> None:
    file, changes, figure = WORSE[what]
    text = changed(sources_of("chamber")[file], *changes)
    timing = measure(chamber, whole("chamber", changed={file: text}))
    assert figure in failed(timing)
    found = timing.figures[figure]
    if what == "a busy wait":
        assert found.where in {"send_cell", "lcd_tick"}
        assert found.worst == pytest.approx(150, abs=2)
        return
    assert failed(timing) == {figure}
    if what == "interrupts off":
        assert (found.where, found.worst) == ("panel_tick", pytest.approx(60, abs=2))
    if what == "a loop that loses ticks":
        assert found.details["drift_per_hour"] > 500_000
    if what == "a key that is shown with the next step":
        assert found.worst is None
        assert found.details["not_shown"] > 100


def test_a_controller_without_keys() -> None:
    text = changed("chamber", (KEYPAD, ""), (PRESSES, ""), ("initial: 20 °C", "initial: 50 °C"))
    controller = spec_of(text).controller
    assert not any(part.kind == "lcd_keypad" for part in controller.interfaces)
    timing = measure(controller, whole(text))
    assert "button_to_display_ms" not in timing.figures
    assert failed(timing) == set()


def test_a_fan_beside_a_cooler_and_a_watched_relay_keeps_interrupts_short() -> None:
    """The longest tick that a single loop has."""
    spec = changed(
        "fabricator", (", current: {sensor: current, limit: 3 A}", ""),
        (", current: {of: heater}", ""), (f"  {CURRENT}\n", ""),
        ("\nloops:", f"\n  blower: {{{BLOWER}}}\n\nloops:"),
        ("    heater: heater\n", "    heater: heater\n    fan: blower\n"),
    )  # fmt: skip
    timing = measure(spec_of(spec).controller, whole(spec))
    assert failed(timing) == set()
    masked_us = timing.figures["longest_interrupts_off_us"].worst
    assert masked_us is not None
    assert masked_us < SHORT_US
