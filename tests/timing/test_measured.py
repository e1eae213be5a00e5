"""The chamber's binary keeps its times, and one made worse does not pass."""

from collections.abc import Callable
from pathlib import Path

import pytest

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.sim.timing import Timing, measure
from heatwright.spec import Controller, load, load_text

EXAMPLE = Path(__file__).parents[2] / "spec" / "examples" / "chamber.yaml"
KEYPAD = "  - {kind: lcd_keypad, loop: air, step: 10 K}\n"
PRESSES = "    - {at: 10 s, press: up, times: 3}\n"

Worse = Callable[..., Timing]


@pytest.fixture(scope="module")
def timing(chamber: Controller, chamber_elf: Path) -> Timing:
    return measure(chamber, chamber_elf, static_stack_bytes=1000)


@pytest.fixture
def worse(chamber: Controller, tmp_path: Path) -> Worse:
    """Measures the chamber's firmware with texts of a file replaced."""

    def measured(file: str, *changes: tuple[str, str]) -> Timing:
        write(render(plan_firmware(load(EXAMPLE))), tmp_path)
        path = tmp_path / "src" / file
        text = path.read_text(encoding="utf-8")
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        path.write_text(text, encoding="utf-8")
        return measure(chamber, build(tmp_path).elf)

    return measured


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
    assert 0.9 < timing.idle_fraction < 1


def test_functions_are_told_by_their_longest_call(timing: Timing) -> None:
    cycles = [each.longest for each in timing.functions]
    assert len(cycles) == 10
    assert cycles == sorted(cycles, reverse=True)


def test_the_json_has_every_figure_with_its_limit(timing: Timing) -> None:
    found = timing.as_json()
    assert found["passed"] is True
    for name, figure in timing.figures.items():
        assert found[name]["worst"] == figure.worst
        assert found[name]["limit"] == figure.limit
        assert found[name]["passed"] is True


def test_more_stack_than_the_code_explains(chamber: Controller, chamber_elf: Path) -> None:
    timing = measure(chamber, chamber_elf, static_stack_bytes=40)
    assert failed(timing) == {"stack_used_bytes"}


def test_a_busy_wait(worse: Worse) -> None:
    timing = worse("lcd.c", ("EXECUTION_US = 40", "EXECUTION_US = 150"))
    assert "longest_busy_wait_us" in failed(timing)
    assert timing.figures["longest_busy_wait_us"].where in {"send_cell", "lcd_tick"}
    assert timing.figures["longest_busy_wait_us"].worst == pytest.approx(150, abs=2)


def test_interrupts_off(worse: Worse) -> None:
    """Less than a 1-Wire slot may take, but it is none."""
    headers = '#include "panel.h"\n#include <avr/interrupt.h>\n#include <util/delay.h>\n'
    timing = worse(
        "panel.c",
        ('#include "panel.h"\n', headers),
        (
            "case KEY_UP:\n",
            "case KEY_UP:\n        cli();\n        _delay_us(50);\n        sei();\n",
        ),
    )
    assert failed(timing) == {"longest_interrupts_off_us"}
    assert timing.figures["longest_interrupts_off_us"].where == "panel_tick"
    assert timing.figures["longest_interrupts_off_us"].worst == pytest.approx(50, abs=2)


def test_a_loop_that_loses_ticks(worse: Worse) -> None:
    timing = worse(
        "loop_air.c",
        (
            "    ticks_left = LOOP_AIR_PERIOD_TICKS;\n    step();",
            "    ticks_left = (uint16_t)(LOOP_AIR_PERIOD_TICKS + ((loop_air.steps & 63u) == 0));\n"
            "    step();",
        ),
    )
    assert failed(timing) == {"step_jitter_us"}
    assert timing.figures["step_jitter_us"].details["drift_per_hour"] > 500_000


def test_a_display_that_sends_one_cell_a_tick_the_temperature_first(worse: Worse) -> None:
    timing = worse(
        "lcd.c",
        ("position = LCD_COLUMNS - 1u;", "position = LCD_CELLS - 1u;"),
        ("CELLS_A_TICK = 3", "CELLS_A_TICK = 1"),
    )
    assert failed(timing) == {"button_to_display_ms"}


def test_a_display_that_is_set_up_again_slowly(worse: Worse) -> None:
    timing = worse("lcd.c", ("LATER_A_TICK = sizeof START_UP", "LATER_A_TICK = 2"))
    assert failed(timing) == {"button_to_display_ms"}


def test_a_key_that_is_shown_with_the_next_step(worse: Worse) -> None:
    timing = worse(
        "panel.c",
        ("        break;\n    }\n    show_setpoint_or_fault();\n}", "        break;\n    }\n}"),
    )
    assert failed(timing) == {"button_to_display_ms"}
    assert timing.figures["button_to_display_ms"].worst is None
    assert timing.figures["button_to_display_ms"].details["not_shown"] > 100


def test_a_controller_without_keys(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8").replace(KEYPAD, "").replace(PRESSES, "")
    spec = load_text(text, "keyless.yaml")
    assert not any(part.kind == "lcd_keypad" for part in spec.controller.interfaces)
    write(render(plan_firmware(spec)), tmp_path)
    timing = measure(spec.controller, build(tmp_path).elf)
    assert "button_to_display_ms" not in timing.figures
    assert failed(timing) == set()
