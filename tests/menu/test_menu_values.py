"""Single values by keys, faults on every screen, keys that repeat."""

import pytest
from menu_desk import MenuDesk, scripts_of

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


def to(title: str) -> str:
    """Return the keys that lead to a value, from the first screen."""
    return "left" + " select" * TITLES.index(title)


HOLD, THERMOCOUPLE, TRIPS_AT = map(to, ("Hold setpoint?", "Thermocouple", "Trips at"))


def test_select_leads_from_value_to_value_and_round(desk: MenuDesk) -> None:
    found = [desk.press("left")[0]]
    found += [desk.press("select")[0] for _ in TITLES]
    assert found == [*TITLES, "Setpoint"]


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


SCRIPTS = scripts_of(f"""
# up and down move the setpoint and stop at its ends
    left up up down -> Setpoint | 21°C
    down:6          -> Setpoint | 0°C
                    -> {SETPOINT}=0
    up:30           -> Setpoint | 1100°C
# a key that is held repeats, and then in coarse steps
    left up:0.4 -> {SETPOINT}=21
    up:1.56     -> {SETPOINT}={21 + 1 + 11}
    up:3.56     -> {SETPOINT}={33 + 1 + 19 + 10 * 12}
# a key that is held on select acts once
    right right select:5 -> SELECT: start | 1 anneal
# only up and down repeat
    select  -> 20°C >20°C     | off
    right:3 -> All  0d00h00m  | Seg. 0d00h00m
# the loop is switched on when asked twice, and off at once
    {HOLD} -> Hold setpoint? | off
    up     -> SELECT: keep   | on
    step   -> {ENABLED}=0
    down   -> Hold setpoint? | off
    step   -> {ENABLED}=0
    up     -> SELECT: keep   | on
    step   -> {ENABLED}=0
    select -> Hold setpoint? | on
    step   -> {ENABLED}=1
    down   -> Hold setpoint? | off
    step   -> {ENABLED}=0
# a program takes setpoint and switch away
    right right select select left left step
    left up     -> not possible | 20°C
    select      -> Setpoint     | 20°C
    select down -> not possible | off
    step        -> state=running
# the thermocouple is chosen and kept
    {THERMOCOUPLE} -> Thermocouple | K
    up     -> SELECT: keep | S
    up     -> SELECT: keep | K
    down   -> SELECT: keep | S
    select -> Thermocouple | S
    wait:11 power -> settings.chamber_thermocouple={TYPE_S}
# the thermocouple is not changed while the loop is on
    {HOLD} up select right
    {THERMOCOUPLE} up select -> not possible | K
# what is left without select is not changed
    {TRIPS_AT} down right
    {TRIPS_AT} -> Trips at | 1150°C
# what is only shown
    {to("Energy")} -> Energy       | 0.00 kWh
    select         -> EEPROM saves | 0
    up down        -> EEPROM saves | 0
""")


@pytest.mark.parametrize("name", SCRIPTS)
def test_by_keys(desk: MenuDesk, name: str) -> None:
    desk.play(SCRIPTS[name])


@pytest.mark.parametrize(
    ("title", "name"), [("Kp %/K", "kp"), ("Ki %/(Ks)", "ki"), ("Kd %s/K", "kd")]
)
def test_gains_are_kept_through_a_loss_of_power(desk: MenuDesk, title: str, name: str) -> None:
    gain = f"settings.chamber_{name}"
    before = desk.read(gain)
    after = before * 1.05**2
    desk.play(f"""
        {to(title)} -> {title}      | {before:.3f}
        down        -> SELECT: keep | {before / 1.05:.3f}
        up up up    -> SELECT: keep | {after:.3f}
                    -> {gain}={before}
        select      -> {gain}={after}
        power       -> {gain}={after}
    """)


def test_a_gain_is_nothing_below_the_least(desk: MenuDesk) -> None:
    desk.put("settings.chamber_ki", 0.0008)
    desk.press(*to("Ki %/(Ks)").split())
    for keys, kept in (("up", 0.001), ("down", 0.0), ("up", 0.001), ("up", 0.00105)):
        desk.press(keys, "select")
        assert desk.read("settings.chamber_ki") == pytest.approx(kept, rel=1e-6)


def test_a_lowered_maximum_trips_and_is_kept(desk: MenuDesk) -> None:
    desk.press(*to("Trips at").split())
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
    assert desk.press(*to("Faults so far").split())[1].startswith("E1 ")
    assert desk.press("up")[1] == "none"
