"""Off is a level that is forced: by the gate, by zero, and by the first instructions."""

import pytest
from output_firmware import sources_of
from pwm_firmware import PwmBoard

from heatwright.sim.native.pins import pin_number

HEATERS = {
    "timer 2": ("uno", "D3", "976.5625 Hz"),
    "timer 1": ("nano", "D9", "1 kHz"),
    "timer 0": ("leonardo", "D3", "976.5625 Hz"),
    "timer 4": ("mega2560", "D8", "1 kHz"),
    "timer 3": ("atmega1284p", "PB6", "1 kHz"),
    "timer 0 of old": ("atmega32", "PB3", "976.5625 Hz"),
    "timer 1 of old": ("atmega16", "PD5", "1 kHz"),
    "timer 2 of old": ("atmega16", "PD7", "976.5625 Hz"),
    "interrupts": ("uno", "D4", "100 Hz"),
    "interrupts of old": ("atmega32", "PC0", "100 Hz"),
    "interrupts, far port": ("mega2560", "D9", "122 Hz"),
}
TICK_S = 0.01
FIRST = 40
"""Cycles from the reset vector to the heater's pin, some ten instructions on."""


def heated(board: str, pin: str, frequency: str, active: str) -> PwmBoard:
    said = f"kind: pwm, pin: {pin}, frequency: {frequency}, active: {active}, power: 40 W"
    return PwmBoard(board, {"heater": said}, "reset")


@pytest.fixture(params=HEATERS)
def bench(request: pytest.FixtureRequest, active: str) -> PwmBoard:
    return heated(*HEATERS[request.param], active)


pytestmark = pytest.mark.parametrize("active", ["high", "low"])


def test_the_gate_forces_it_off(bench: PwmBoard) -> None:
    heater = bench.outputs["heater"]
    for percent in (50.0, 100.0, 3.0):
        bench.put("permitted", 1)
        bench.ask("heater", percent)
        assert bench.seen("heater", 0.1).share == pytest.approx(percent / 100, abs=0.02)
        bench.put("permitted", 0)
        bench.avr.run(TICK_S)
        assert not heater.on
        assert heater.driven
        assert bench.seen("heater", 0.5).share == 0
        bench.ask("heater", 90.0)
        assert bench.seen("heater", 0.5).share == 0


def test_it_is_off_before_anything_else(bench: PwmBoard) -> None:
    heater = bench.outputs["heater"]
    bench.ask("heater", 60.0)
    assert bench.seen("heater", 0.1).share > 0.5
    bench.avr.reset()
    bench.avr.pins.take()
    reset_at = bench.avr.cycle
    bench.avr.run(0.2)
    assert not heater.on
    assert heater.driven
    events = bench.avr.pins.take()
    mine = events[events["pin"] == pin_number(heater.pin)]
    # The board's resistor first, then the program, and never the load.
    assert mine["cycle"][-1] - reset_at <= FIRST
    assert ((mine["state"] & 1 == 1) == (heater.active == "low")).all()


def test_started_again_without_a_reset_it_is_off(bench: PwmBoard) -> None:
    """A jump to 0 leaves the timers as they were."""
    heater = bench.outputs["heater"]
    profile = bench.avr.profile(bench.program)
    profile.trace("start_again")
    for phase in range(5):
        bench.ask("heater", 60.0)
        assert bench.seen("heater", 0.1 + 0.0003 * phase).share > 0.5
        bench.put("restart", 1)
        bench.avr.run(2 * TICK_S)
        (began,) = profile.entries("start_again")
        events = bench.avr.pins.take()
        mine = events[events["pin"] == pin_number(heater.pin)]
        # Not the program's later start of its outputs: that comes some 300 cycles on.
        assert (mine["cycle"] <= began + FIRST).all()
        assert not heater.on
        assert heater.driven
        assert bench.seen("heater", 0.3).share == 0


def test_what_the_first_instructions_are(active: str) -> None:
    for board, pin, frequency in HEATERS.values():
        said = f"kind: pwm, pin: {pin}, frequency: {frequency}, active: {active}, power: 40 W"
        first = sources_of(board, {"heater": said}, "reset")["reset.c"].partition("heaters_off")[2]
        lines = [line.strip() for line in first.partition("}")[0].splitlines()[2:]]
        assert lines[-2:] == ["pin_output_heater_off();", "pin_output_heater_drive();"]
        assert ("TCCR" in lines[0]) == (frequency in {"1 kHz", "976.5625 Hz"})
