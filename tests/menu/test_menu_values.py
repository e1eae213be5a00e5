"""Single values by keys, faults on every screen, keys that repeat."""

import pytest
from menu_desk import MenuDesk

OVER_TEMPERATURE = 6
TYPE_S = 6
"""The converter's code of the type (MAX31856 data sheet, CR1)."""
TITLES = [
    "Setpoint", "Hold setpoint?", "Kp %/K", "Ki %/(Ks)", "Kd %s/K", "Trips at", "Thermocouple",
    "Energy", "EEPROM saves", "Faults so far",
]  # fmt: skip


def at(desk: MenuDesk, title: str) -> tuple[str, str]:
    """Go to one of the values, from the first screen."""
    desk.press("left")
    return desk.press(*["select"] * TITLES.index(title))


def setpoint_c(desk: MenuDesk) -> float:
    return float(desk.device.read("settings.chamber_setpoint_c"))


def test_select_leads_from_value_to_value_and_round(desk: MenuDesk) -> None:
    found = [desk.press("left")[0]]
    found += [desk.press("select")[0] for _ in TITLES]
    assert found == [*TITLES, "Setpoint"]


def test_up_and_down_move_the_setpoint_and_stop_at_its_ends(desk: MenuDesk) -> None:
    assert desk.press("left", "up", "up", "down") == ("Setpoint", "21°C")
    desk.hold("down", 6.0)
    assert desk.lines == ("Setpoint", "0°C")
    assert setpoint_c(desk) == 0.0
    desk.hold("up", 30.0)
    assert desk.lines == ("Setpoint", "1100°C")


def test_a_key_that_is_held_repeats_and_then_in_coarse_steps(desk: MenuDesk) -> None:
    desk.press("left")
    desk.hold("up", 0.4)
    assert setpoint_c(desk) == 21.0
    desk.hold("up", 1.56)
    assert setpoint_c(desk) == 21.0 + 1 + 11
    desk.hold("up", 3.56)
    assert setpoint_c(desk) >= 33.0 + 20 + 50


def test_a_key_that_is_held_on_select_acts_once(desk: MenuDesk) -> None:
    desk.press("right", "right")
    desk.hold("select", 5.0)
    assert desk.lines == ("SELECT: start", "1 anneal")


def test_the_loop_is_switched_on_when_asked_twice_and_off_at_once(desk: MenuDesk) -> None:
    assert at(desk, "Hold setpoint?") == ("Hold setpoint?", "off")
    assert desk.press("up") == ("SELECT: keep", "on")
    desk.run(1.2)
    assert desk.device.read("loop_chamber.enabled") == 0
    desk.press("select")
    desk.run(1.2)
    assert desk.device.read("loop_chamber.enabled") == 1
    desk.press("down")
    desk.run(1.2)
    assert desk.device.read("loop_chamber.enabled") == 0


def test_a_program_takes_setpoint_and_switch_away(desk: MenuDesk) -> None:
    desk.press("right", "right", "select", "select", "left", "left")
    desk.run(1.2)
    assert desk.press("left", "up") == ("not possible", "20°C")
    desk.press("select")
    assert desk.press("select", "down") == ("not possible", "off")
    desk.run(1.2)
    assert desk.program("state") == 1


@pytest.mark.parametrize(("title", "name"), [("Kp %/K", "kp"), ("Ki %/(Ks)", "ki")])
def test_gains_are_kept_through_a_loss_of_power(desk: MenuDesk, title: str, name: str) -> None:
    before = float(desk.device.read(f"settings.chamber_{name}"))
    at(desk, title)
    assert desk.press("up", "up")[0] == "SELECT: keep"
    assert float(desk.device.read(f"settings.chamber_{name}")) == before
    desk.press("select")
    kept = float(desk.device.read(f"settings.chamber_{name}"))
    assert kept == pytest.approx(before * 1.05**2, rel=1e-6)
    desk.power_cycle()
    assert float(desk.device.read(f"settings.chamber_{name}")) == kept


def test_a_lowered_maximum_trips_and_is_kept(desk: MenuDesk) -> None:
    at(desk, "Trips at")
    desk.hold("down", 11.8)
    desk.press("select")
    lowered_c = float(desk.device.read("settings.chamber_maximum_c"))
    assert 20.0 < lowered_c < 300.0
    desk.run(11.0)
    desk.power_cycle()
    assert float(desk.device.read("settings.chamber_maximum_c")) == lowered_c
    while desk.felt_c < lowered_c + 20:
        desk.felt_c += 4.0
        desk.run(1.0)
    assert desk.device.read("fault.code") == OVER_TEMPERATURE
    assert desk.lines[1] == "E06 TOO HOT"


def test_the_thermocouple_is_chosen_and_kept(desk: MenuDesk) -> None:
    assert at(desk, "Thermocouple") == ("Thermocouple", "K")
    assert desk.press("up") == ("SELECT: keep", "S")
    assert desk.press("select") == ("Thermocouple", "S")
    desk.run(11.0)
    desk.power_cycle()
    assert desk.device.read("settings.chamber_thermocouple") == TYPE_S


def test_the_thermocouple_is_not_changed_while_the_loop_is_on(desk: MenuDesk) -> None:
    at(desk, "Hold setpoint?")
    desk.press("up", "select")
    desk.press("right")
    at(desk, "Thermocouple")
    assert desk.press("up", "select") == ("not possible", "K")


def test_what_is_left_without_select_is_not_changed(desk: MenuDesk) -> None:
    at(desk, "Trips at")
    desk.press("down", "right")
    assert at(desk, "Trips at") == ("Trips at", "1150°C")


@pytest.mark.parametrize("way", [(), ("right",), ("right", "right"), ("right",) * 3, ("left",)])
def test_a_fault_is_on_every_screen_and_only_select_answers(
    desk: MenuDesk, way: tuple[str, ...]
) -> None:
    desk.press(*way)
    desk.device.sensors["chamber"].unplug()
    desk.run(7.0)
    assert desk.lines[1] == "E01 NO SENSOR"
    before = desk.lines
    assert desk.press("right", "left", "up", "down") == before
    desk.device.sensors["chamber"].plug()
    desk.run(2.0)
    desk.press("select")
    assert desk.device.read("fault.code") == 0
    desk.run(1.2)
    assert not desk.lines[1].startswith("E01")


def test_faults_are_listed_the_newest_first(desk: MenuDesk) -> None:
    for act in ("unplug", "plug"):
        getattr(desk.device.sensors["chamber"], act)()
        desk.run(7.0)
    desk.press("select")
    assert at(desk, "Faults so far")[1].startswith("E1 ")
    assert desk.press("up")[1] == "none"
