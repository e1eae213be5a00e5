"""Single values by keys, faults on every screen, keys that repeat."""

import pytest
from menu_desk import RUNNING, MenuDesk

from heatwright.sim.native.analog import millivolts

OVER_TEMPERATURE = 6
TYPE_S = 6
"""The converter's code of the type (MAX31856 data sheet, CR1)."""
TITLES = [
    "Setpoint", "Hold setpoint?", "Kp %/K", "Ki %/(Ks)", "Kd %s/K", "Trips at", "Thermocouple",
    "Energy", "EEPROM saves", "Faults so far",
]  # fmt: skip
SETPOINT = "settings.chamber_setpoint_c"
ENABLED = "loop_chamber.enabled"


def test_select_leads_from_value_to_value_and_round(desk: MenuDesk) -> None:
    found = [desk.press("left")[0]]
    found += [desk.press("select")[0] for _ in TITLES]
    assert found == [*TITLES, "Setpoint"]


def test_up_and_down_move_the_setpoint_and_stop_at_its_ends(desk: MenuDesk) -> None:
    desk.walk(("left up up down", "Setpoint", "21°C"))
    assert desk.press("down", for_s=6.0) == ("Setpoint", "0°C")
    assert desk.read(SETPOINT) == 0.0
    assert desk.press("up", for_s=30.0) == ("Setpoint", "1100°C")


def test_a_key_that_is_held_repeats_and_then_in_coarse_steps(desk: MenuDesk) -> None:
    desk.press("left")
    desk.press("up", for_s=0.4)
    assert desk.read(SETPOINT) == 21.0
    desk.press("up", for_s=1.56)
    assert desk.read(SETPOINT) == 21.0 + 1 + 11
    desk.press("up", for_s=3.56)
    assert desk.read(SETPOINT) >= 33.0 + 20 + 50


def test_a_key_that_is_held_on_select_acts_once(desk: MenuDesk) -> None:
    desk.press("right", "right")
    assert desk.press("select", for_s=5.0) == ("SELECT: start", "1 anneal")


def test_only_up_and_down_repeat(desk: MenuDesk) -> None:
    desk.walk(("select", "20°C >20°C", "off"))
    assert desk.press("right", for_s=3.0) == ("All  0d00h00m", "Seg. 0d00h00m")


@pytest.mark.parametrize(
    ("codes", "shown"),
    [((0, 59), ("20°C >20°C", "off")), ((60, 199), ("Setpoint", "21°C")),
     ((200, 399), ("Setpoint", "19°C")), ((400, 599), ("Edit program?", "1 anneal")),
     ((600, 899), ("Hold setpoint?", "off")), ((900, 1023), ("Setpoint", "20°C"))],
)  # fmt: skip
def test_thresholds_of_the_keys(
    desk: MenuDesk, codes: tuple[int, int], shown: tuple[str, str]
) -> None:
    """Right, up, down, left, select, none; each from its lowest code to its highest."""
    for code in codes:
        desk.press("right", "left", "left", "right", "left")
        desk.device.avr.adc.set(0, millivolts(code))
        desk.run(0.3)
        assert desk.lines == shown, code
        desk.power_cycle()


def test_the_loop_is_switched_on_when_asked_twice_and_off_at_once(desk: MenuDesk) -> None:
    assert desk.go_to("Hold setpoint?") == ("Hold setpoint?", "off")
    for key, shown, enabled in (
        ("up", ("SELECT: keep", "on"), 0),
        ("down", ("Hold setpoint?", "off"), 0),
        ("up", ("SELECT: keep", "on"), 0),
        ("select", ("Hold setpoint?", "on"), 1),
        ("down", ("Hold setpoint?", "off"), 0),
    ):
        assert desk.press(key) == shown
        desk.run()
        assert desk.read(ENABLED) == enabled


def test_a_program_takes_setpoint_and_switch_away(desk: MenuDesk) -> None:
    desk.press("right", "right", "select", "select", "left", "left")
    desk.run()
    desk.walk(("left up", "not possible", "20°C"), ("select", "Setpoint", "20°C"),
              ("select down", "not possible", "off"))  # fmt: skip
    desk.run()
    assert desk.program("state") == RUNNING


@pytest.mark.parametrize(
    ("title", "name"), [("Kp %/K", "kp"), ("Ki %/(Ks)", "ki"), ("Kd %s/K", "kd")]
)
def test_gains_are_kept_through_a_loss_of_power(desk: MenuDesk, title: str, name: str) -> None:
    gain = f"settings.chamber_{name}"
    before = desk.read(gain)
    assert desk.go_to(title) == (title, f"{before:.3f}")
    desk.walk(("down", "SELECT: keep", f"{before / 1.05:.3f}"),
              ("up up up", "SELECT: keep", f"{before * 1.05**2:.3f}"))  # fmt: skip
    assert desk.read(gain) == before
    desk.press("select")
    kept = desk.read(gain)
    assert kept == pytest.approx(before * 1.05**2, rel=1e-6)
    desk.power_cycle()
    assert desk.read(gain) == kept


def test_a_gain_is_nothing_below_the_least(desk: MenuDesk) -> None:
    desk.put("settings.chamber_ki", 0.0008)
    desk.go_to("Ki %/(Ks)")
    for keys, kept in (("up", 0.001), ("down", 0.0), ("up", 0.001), ("up", 0.00105)):
        desk.press(keys, "select")
        assert desk.read("settings.chamber_ki") == pytest.approx(kept, rel=1e-6)


def test_what_is_only_shown(desk: MenuDesk) -> None:
    assert desk.go_to("Energy") == ("Energy", "0.00 kWh")
    desk.walk(("select", "EEPROM saves", "0"), ("up down", "EEPROM saves", "0"))


def test_a_lowered_maximum_trips_and_is_kept(desk: MenuDesk) -> None:
    desk.go_to("Trips at")
    desk.press("down", for_s=11.8)
    desk.press("select")
    lowered_c = desk.read("settings.chamber_maximum_c")
    assert 20.0 < lowered_c < 300.0
    desk.run(11.0)
    desk.power_cycle()
    assert desk.read("settings.chamber_maximum_c") == lowered_c
    desk.warm_to(lowered_c + 20)
    assert desk.read("fault.code") == OVER_TEMPERATURE
    assert desk.lines[1] == "E06 TOO HOT"


def test_the_thermocouple_is_chosen_and_kept(desk: MenuDesk) -> None:
    assert desk.go_to("Thermocouple") == ("Thermocouple", "K")
    for key, letter in (("up", "S"), ("up", "K"), ("down", "S")):
        assert desk.press(key) == ("SELECT: keep", letter)
    assert desk.press("select") == ("Thermocouple", "S")
    desk.run(11.0)
    desk.power_cycle()
    assert desk.read("settings.chamber_thermocouple") == TYPE_S


def test_the_thermocouple_is_not_changed_while_the_loop_is_on(desk: MenuDesk) -> None:
    desk.go_to("Hold setpoint?")
    desk.press("up", "select", "right")
    desk.go_to("Thermocouple")
    desk.walk(("up select", "not possible", "K"))


def test_what_is_left_without_select_is_not_changed(desk: MenuDesk) -> None:
    desk.go_to("Trips at")
    desk.press("down", "right")
    assert desk.go_to("Trips at") == ("Trips at", "1150°C")


@pytest.mark.parametrize("way", ["", "right", "right right", "right right right", "left"])
def test_a_fault_is_on_every_screen_and_only_select_answers(desk: MenuDesk, way: str) -> None:
    desk.press(*way.split())
    desk.device.sensors["chamber"].unplug()
    desk.run(7.0)
    assert desk.lines[1] == "E01 NO SENSOR"
    before = desk.lines
    assert desk.press("up", "up", "right", "left", "down") == before
    assert desk.read(SETPOINT) == desk.felt_c
    desk.device.sensors["chamber"].plug()
    desk.run(2.0)
    desk.press("select")
    assert desk.read("fault.code") == 0
    desk.run()
    assert not desk.lines[1].startswith("E01")


def test_faults_are_listed_the_newest_first(desk: MenuDesk) -> None:
    for act in ("unplug", "plug"):
        getattr(desk.device.sensors["chamber"], act)()
        desk.run(7.0)
    desk.press("select")
    assert desk.go_to("Faults so far")[1].startswith("E1 ")
    assert desk.press("up")[1] == "none"
