"""The simulated driver: what it counts, and what it finds fault with."""

import numpy as np
import pytest
from rig.avr import running

from heatwright.sim.avr import Avr
from heatwright.sim.outputs.stepper import Stepper, attach
from heatwright.spec import BOARDS
from heatwright.spec import Stepper as StepperOutput

OUTPUT = StepperOutput.model_validate(
    {
        "kind": "stepper", "step": "D8", "direction": "D9", "enable": "D10",
        "steps": 200, "microsteps": 1, "lead": "2 mm",
        "maximum": "10 mm/s", "acceleration": "10 mm/s²",
    }
)  # fmt: skip
STEP, DIR, ENABLE = "PORTB ^= 1;", "PORTB ^= 2;", "PORTB ^= 4;"
START = "DDRB = 7; PORTB = 4;"
WAIT = "_delay_us(10);"
PULSE = f"{STEP} {WAIT} {STEP} {WAIT}"


def attached(body: str) -> tuple[Avr, Stepper]:
    """A program and its driver: PB0 is STEP, PB1 DIR, PB2 ENABLE (low is on)."""
    avr = running(f"int main(void) {{ {START} {WAIT} {body} for (;;) {{}} }}")
    return avr, attach(avr, BOARDS["uno"], OUTPUT)


def driven(body: str, size: int = 1000) -> Stepper:
    """The driver after a program has run, fed with so many events at a time."""
    avr, driver = attached(body)
    avr.run(0.001)
    events = avr.pins.take()
    for first in range(0, len(events), size):
        driver.feed(events[first : first + size], np.zeros(0))
    return driver


def test_steps_forward_and_backward() -> None:
    driver = driven(f"{ENABLE} {DIR} {WAIT} {PULSE * 5} {DIR} {WAIT} {PULSE * 2}")
    assert (driver.position, driver.violations, driver.missed) == (3, 0, 0)
    assert driver.on
    assert driver.position_mm == pytest.approx(0.03)
    assert driver.travel_mm() == pytest.approx(0.03)
    assert driver.travel_mm() == 0
    assert driver.steps["way"].tolist() == [1, 1, 1, 1, 1, -1, -1]
    assert (np.diff(driver.steps["cycle"]) >= 320).all()


def test_it_waits_to_be_fed_once_it_has_stepped() -> None:
    avr, driver = attached(f"{ENABLE} {WAIT} {PULSE}")
    avr.run(15e-6)
    assert not driver.waits
    avr.run(0.001)
    assert driver.waits
    driver.feed(avr.pins.take(), np.zeros(0))
    assert not driver.waits


def test_none_without_enable() -> None:
    driver = driven(f"{PULSE * 3} {ENABLE} {WAIT} {PULSE}")
    assert (driver.position, driver.violations, driver.missed) == (-1, 0, 3)


def test_the_boards_resistor_holds_it_off() -> None:
    assert not driven("DDRB = 0;").on


@pytest.mark.parametrize(
    ("body", "violations"),
    [
        # A data sheet's microsecond is 16 cycles; a change of a port takes 3.
        (f"{STEP} __builtin_avr_delay_cycles(24); {STEP}", 1),  # 1.9 us high
        (f"{STEP} __builtin_avr_delay_cycles(30); {STEP}", 0),
        (f"{PULSE} {STEP} {WAIT} {STEP} __builtin_avr_delay_cycles(24); {PULSE}", 1),  # 1.9 us low
        (f"{DIR} {PULSE}", 1),  # 650 ns of set-up
        (f"{DIR} __builtin_avr_delay_cycles(9); {PULSE}", 0),
        (f"{STEP} {DIR} {WAIT} {STEP}", 1),  # 650 ns of hold
        (f"{STEP} __builtin_avr_delay_cycles(9); {DIR} {WAIT} {STEP}", 0),
        (f"{ENABLE} {WAIT} {ENABLE} {PULSE}", 1),
    ],
    ids=["short", "long", "close", "turned", "turned early", "turning", "turned late", "woken"],
)
def test_edges_too_close_are_counted(body: str, violations: int) -> None:
    driver = driven(f"{ENABLE} {WAIT} {body}")
    assert driver.violations == violations


def test_it_does_not_matter_where_the_record_is_cut() -> None:
    body = f"{ENABLE} {DIR} {WAIT} {PULSE * 5} {DIR} {PULSE * 2} {STEP} {DIR} {WAIT} {STEP}"
    whole = driven(body)
    for size in (1, 2, 3, 5):
        parts = driven(body, size)
        assert (parts.position, parts.violations) == (whole.position, whole.violations)
