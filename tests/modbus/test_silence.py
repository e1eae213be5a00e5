"""The silence that ends a frame: who measures it, how long it is, and what the titles become."""

import re

import pytest
from modbus_host import SLAVE
from rig.specs import sources_of, spec_of

from heatwright.generator.plan.text import c_string
from heatwright.generator.plan.timers import round_interval
from heatwright.spec import BOARDS
from heatwright.spec.boards import Timer
from heatwright.spec.interfaces import BUS_BAUDS
from heatwright.spec.timers import allocate

FORMS = {"even": 11, "odd": 11, "none": 11, "none, stop_bits: 1": 10, "even, stop_bits: 2": 12}


@pytest.mark.parametrize("baud", BUS_BAUDS)
@pytest.mark.parametrize("form", FORMS)
def test_it_is_three_and_a_half_characters_or_1750_us(baud: int, form: str) -> None:
    text = SLAVE.replace("baud: 1200, parity: odd", f"baud: {baud}, parity: {form}")
    config = sources_of(text)["config.h"]
    counts = re.search(r"clock / (\d+) \*/\n#define MODBUS_SILENCE_COUNTS (\d+)u", config)
    matches = re.search(r"#define MODBUS_SILENCE_MATCHES (\d+)u", config)
    assert counts is not None
    times = int(matches[1]) if matches else 1
    step_s = int(counts[1]) * times / 16e6
    wanted_s = 1.75e-3 if baud > 19200 else 3.5 * FORMS[form] / baud
    assert wanted_s - 1e-12 <= int(counts[2]) * step_s < wanted_s + step_s
    assert int(counts[2]) < 256


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("clock_hz", [1_000_000, 8_000_000, 14_745_600, 16_000_000, 20_000_000])
def test_any_timer_measures_any_silence(bits: int, clock_hz: int) -> None:
    timer = Timer(bits, (1, 8, 64, 256, 1024), ("A", "B"))
    for shortest_s in (0.00175, 0.002005, 0.0035, 0.032084, 0.035):
        prescaler, counts, matches = round_interval(clock_hz, timer, shortest_s)
        step_s = prescaler * matches / clock_hz
        assert shortest_s - 1e-12 <= counts * step_s < shortest_s + step_s
        assert 1 < counts < 1 << bits
        assert matches == 1 or prescaler == 1024 or bits == 8


def test_it_has_a_timer_of_its_own() -> None:
    use = allocate(spec_of(SLAVE).controller)
    others = {use.tick, *use.one_wire.values(), *use.steppers.values()}
    assert use.silence is not None
    assert use.silence not in others | {channel.timer for channel in use.pwm.values()}
    assert use.silence in BOARDS["mega2560"].timers
    without = spec_of(SLAVE[: SLAVE.index("interfaces:")].replace("autotune: {}", "")).controller
    assert allocate(without).silence is None


@pytest.mark.parametrize(
    ("text", "literal"),
    [
        ("Dryer", '"Dryer"'),
        ('a "b" \\ c', '"a \\"b\\" \\\\ c"'),
        ("??/ and ???", '"?\\?/ and ?\\?\\?"'),
        ("50 °C\n\0", '"50 ?C?\\?"'),
        ("%s {{ x }}", '"%s {{ x }}"'),
    ],
)
def test_a_title_becomes_a_literal(text: str, literal: str) -> None:
    assert c_string(text) == literal
