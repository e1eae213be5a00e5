"""What drawing controllers has brought to light, each as the smallest change that shows it."""

import pytest
from rig.avr import whole
from rig.specs import changed, controller_of, files_of, spec_of

from heatwright.spec import SpecError

PLAIN = changed("chamber").partition("simulation:")[0]
PERIOD, STALE = "period: 1 s", "stale_after: 5 s"
RULES = """      heating: {rise: 2 K, within: 120 s}
      runaway: {above: 10 K, for: 60 s}
"""
RULE_NAMES = ("heating", "runaway", "frozen", "rising_while_off")
SENSOR = "{kind: ds18b20, pin: A1, resolution: 12 bit}"


def test_as_many_periods_as_can_be_counted_are_taken_as_the_file_says_them() -> None:
    """0.83 · 255 is a little less than 211.65 in binary, and 70.2 − 10.3 than 59.9."""
    text = changed(PLAIN, (PERIOD, "period: 0.83 s"), (STALE, "stale_after: 211.65 s"),
                   ("minimum: 10 °C, maximum: 70 °C", "minimum: 10.3 °C, maximum: 70.2 °C"),
                   ("step: 10 K", "step: 59.9 K"))  # fmt: skip
    assert controller_of(text).loops["air"].protection.stale_after_s == 211.65
    assert "STALE_STEPS 255u" in files_of(text)["src/config.h"]


def test_permits_longer_than_their_counters_compile() -> None:
    no_rules = "".join(f"      {name}: off\n" for name in RULE_NAMES)
    long_ago = changed(
        PLAIN, (PERIOD, "period: 10 min"), (STALE, "stale_after: 20 min"), (RULES, no_rules)
    )
    config = files_of(long_ago)["src/config.h"]
    assert "LOOP_AIR_PERMIT_TICKS 65535u" in config
    assert "LOOP_AIR_SENSOR_PERMIT_TICKS 65535u" in config
    whole(long_ago)


def test_a_heater_may_wait_for_its_window_before_it_heats() -> None:
    heating = changed("chamber", ("rise: 2 K, within: 120 s", "rise: 0.1 K, within: 30 s"))
    spec_of(heating)
    with pytest.raises(SpecError, match=r"heating\.within: this plant, healthy"):
        spec_of(changed(heating, ("digital, pin: D3", "time_proportional, window: 40 s, pin: D3")))


def test_two_converters_with_registers_share_no_name() -> None:
    tip = "{{kind: max31856, chip_select: D{}, clock: D{}, data_in: D{}, data_out: D{}}}"
    air, wall = tip.format(22, 23, 24, 25), tip.format(30, 31, 32, 33)
    loop = PLAIN[PLAIN.index("  air:\n    sensor") : PLAIN.index("safety:")].rstrip()
    other = changed(loop, ("  air:\n", "  wall:\n"), ("sensor: air", "sensor: wall"),
                    ("heater: heater", "heater: other"))  # fmt: skip
    other = other.replace("    fan: fan", "    # ")
    whole(changed(PLAIN, (SENSOR, f"{air}\n  wall: {wall}"), (loop, f"{loop}\n{other}"),
                  ("outputs:", "outputs:\n  other: {kind: digital, pin: D40, power: 9 W}"),
                  ("board: uno", "board: mega2560")))  # fmt: skip
