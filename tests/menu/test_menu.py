"""The menu by keys: values, faults on every screen, keys that repeat, programs from end to end."""

import pytest
from menu_desk import CONTROLLER, STATES, MenuDesk, scripts_of
from rig.avr import whole

from heatwright.sim.device import AvrDevice
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


@pytest.fixture(scope="session")
def device() -> AvrDevice:
    return AvrDevice(CONTROLLER, whole("kiln_uno"))


@pytest.fixture
def desk(device: AvrDevice) -> MenuDesk:
    """The kiln with keys, nothing on, its first screen shown."""
    return MenuDesk(device)


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


VALUES = scripts_of(f"""
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


# -- programs by keys: started, paused, skipped, ended, changed, kept

SECOND_TARGET_C = 260.0
"""Of the example's program, which has 6 segments."""
NAME = "right " * 12
"""From the first letter of a name to the first segment."""
EDIT = "right right right"
"""To the screen that changes programs."""
STARTED = "right right select select step -> state=running"
NEW = f"{EDIT} up select select"
"""To the first segment of a new program."""
EIGHT_RAMPS = "\n".join(
    f"up -> Segment {number} | ramp in a time\nright right right" for number in range(1, 9)
)

TOLD = [
    ((0, 0, 0), "off"), ((0, 0, 1), "finished"), ((0, 0, 2), "stopped"),
    ((0, 0, 3), "ended by fault"), ((0, 0, 4), "power cut: cold"), ((0, 0, 5), "power cut: lost"),
    ((1, 0, 0), "1/6 runs"), ((1, 1, 0), "1/6 held back"), ((1, 2, 0), "1/6 to target"),
    ((1, 3, 0), "1/6 SELECT: on"), ((2, 0, 0), "1/6 paused"), ((3, 0, 0), "1/6 returning"),
    ((4, 0, 0), "power was cut"),
]  # fmt: skip
"""State, what it waits for, and how the last one ended; and what the first screen says of it."""


@pytest.mark.parametrize(("state", "shown"), TOLD)
def test_the_first_screen_tells_temperature_setpoint_and_state(
    desk: MenuDesk, state: tuple[int, int, int], shown: str
) -> None:
    assert desk.lines == ("20°C >20°C", "off")
    desk.put("program.segment", 1)
    desk.put("program.segments", 6)
    desk.put("program.setpoint_c", 321)
    for member, value in zip(("state", "waiting", "ended"), state, strict=True):
        desk.put(f"program.{member}", value)
    setpoint = 321 if state[0] else 20
    desk.play(f"up -> 20°C >{setpoint}°C | {shown}")  # a key without a use: shown anew


PROGRAMS = scripts_of(f"""
# a program is started by two selects
    right right -> Start program? | 1 anneal
    select      -> SELECT: start  | 1 anneal
    step        -> state=idle
    select step -> state=running number=1
    left left   -> 20°C >20°C     | 1/6 runs
# any other key takes the first select back
    right right select -> SELECT: start  | 1 anneal
    left right         -> Start program? | 1 anneal
    select step        -> state=idle
    right left         -> Start program? | 1 anneal
    select step        -> state=idle
    up down            -> Start program? | 1 anneal
    select step        -> state=idle
    down up            -> Start program? | 1 anneal
    select step        -> state=idle
# an empty place cannot be started
    right right up -> Start program? | 2 (empty)
    select select  -> not possible   | 2 (empty)
    up             -> Start program? | 1 anneal
    step           -> state=idle
# a pause is one select away, and so is the way back
    {STARTED}
                                -> Program:   | pause
    select step                 -> state=paused
                                -> Program:   | resume
    left left                   -> 20°C >20°C | 1/6 paused
    right right select wait:1.5 -> state=running
# skip, stop and go to are asked for twice
    {STARTED}
    up                 -> Program:       | skip segment
    select             -> SELECT does it | skip segment
    step               -> segment=1
    select step        -> segment=2
    up up up up up     -> Program:       | go to 4
    select select step -> segment=4
    left right up up   -> Program:       | stop
    select select step -> state=idle ended=2
    left left          ->                | stopped
# choices end with the last segment
    {STARTED}
    down -> Program: | go to 6
    up   -> Program: | pause
# what cannot be done is refused until another is chosen
    {STARTED}
    select step
    up            -> Program:     | skip segment
    select select -> not possible | skip segment
    up            -> Program:     | stop
                  -> state=paused
# a program has as many segments as there is room for, and SELECT alone saves it
    {NEW}
    {EIGHT_RAMPS}
                  -> Segment 8     | 60 min
    select        -> SELECT: save  | LEFT: back
    up right      -> SELECT: save  | LEFT: back
    select        -> saving        | 2 new
    wait:5 up     -> Edit program? | 1 anneal
    down          -> Edit program? | 2 new
# a changed program is kept through a loss of power
    {EDIT}     -> Edit program?  | 1 anneal
    select     -> Name, letter 1 | [anneal      ]
    up         -> Name, letter 1 | [bnneal      ]
    {NAME}     -> Segment 1      | ramp at a rate
    right      -> Segment 1      | to 200°C
    up up down -> Segment 1      | to 201°C
    right      -> Segment 1      | 300 K/h
    down       -> Segment 1      | 299 K/h
    right      -> Segment 2      | fast as it can
    up         -> Segment 2      | hold a time
    right      -> Segment 2      | 60 min
    select     -> SELECT: save   | LEFT: back
    select     ->                | 1 bnneal
    power {EDIT} select select -> Segment 1 | ramp at a rate
    right      -> Segment 1      | to 201°C
    right      -> Segment 1      | 299 K/h
    right      -> Segment 2      | hold a time
    right      -> Segment 2      | 60 min
# what is not saved is not kept
    {EDIT} select up left         -> Edit program? | 1 anneal
    select select right up select -> SELECT: save  | LEFT: back
    left                          -> Segment 1     | to 201°C
# a new program is written from nothing and runs
    {EDIT} up select -> Name, letter 1 | [new         ]
    select           -> Segment 1 | end
    up               -> Segment 1 | ramp in a time
    right            -> Segment 1 | to 0°C
    up:5             -> Segment 1 | to {1 + 19 + 10 * 26}°C
    right            -> Segment 1 | 60 min
    right            -> Segment 2 | end
    down             -> Segment 2 | hold for SELECT
    select select wait:2         -> Edit program? | 2 new
    left up select select step   -> state=running number=2 segments=2
# end in the middle cuts off what follows
    {EDIT} select select right right right -> Segment 2 | fast as it can
    down down down                         -> Segment 2 | end
    right                                  -> Segment 2 | end
    select select wait:2 left select select step -> segments=1
# a program is not started as it was before it is saved
    {EDIT} select select right up select
    select:0.03 left:0.03 select:0.03 select:0.03
    wait:0.1                   -> not possible |
    wait:2                     -> state=idle
    up down select select step -> state=running to_dc=2010
# what was refused once is not held against what is chosen next
    {EDIT} select select right up select
    select:0.03 select:0.03 select:0.03 select:0.03 select:0.03 -> not possible | LEFT: back
    {"left " * 14} -> Edit program? | 1 anneal
# a running program is not changed by what is saved
    {STARTED} to_dc=2000
    right select select right up select select wait:2 -> to_dc=2000
# each kind begins with something that works
    {NEW}
    up -> Segment 1 | ramp in a time
    up -> Segment 1 | ramp at a rate
    up -> Segment 1 | fast as it can
    up -> Segment 1 | hold a time
    up -> Segment 1 | hold for SELECT
    up -> Segment 1 | end
    up up right            -> Segment 1 | to 0°C
    right                  -> Segment 1 | 100 K/h
    left left up up right  -> Segment 1 | 60 min
    up up down             -> Segment 1 | 61 min
    up:4.56                ->           | {61 + 1 + 19 + 10 * 22} min
""")  # noqa: S608 - no SQL
"""A key that is held: a step each tenth of a second after half a second, and ten times as much from
the twentieth."""


@pytest.mark.parametrize("script", [*PROGRAMS.values(), *VALUES.values()], ids=[*PROGRAMS, *VALUES])
def test_by_keys(desk: MenuDesk, script: str) -> None:
    desk.play(script)


def test_a_program_that_has_ended_in_between_is_not_started_by_who_meant_another(
    desk: MenuDesk,
) -> None:
    """The second SELECT of "skip" meets a machine that is idle by then."""
    desk.play(f"{STARTED}\nup select")
    desk.put("program.state", STATES["idle"])
    desk.play("select -> SELECT: start | 1 anneal\nstep -> state=idle")


def test_who_waits_for_the_operator_gets_him_on_the_first_screen(desk: MenuDesk) -> None:
    desk.play(f"{STARTED}\nup up up up up select select")  # go to segment 3
    desk.warm_to(SECOND_TARGET_C)
    desk.play("wait:10 left left -> | 3/6 SELECT: on\nselect step -> segment=4")


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [(93_784, "1d02h03m"), (45_300, "0d12h35m"), (86_340, "0d23h59m"), (86_400, "1d00h00m")],
)
def test_times_are_shown_in_days_hours_and_minutes(
    desk: MenuDesk, seconds: int, shown: str
) -> None:
    desk.play(STARTED)
    for name, line in (("clock", "All "), ("segment_clock", "Seg.")):
        desk.put("program.segment_clock", 0)
        desk.put(f"program.{name}", seconds)
        desk.play("wait:1 left")
        assert f"{line} {shown}" in desk.lines
        desk.press("right")


def test_a_name_is_of_any_letters_but_those_that_would_end_a_text(desk: MenuDesk) -> None:
    """The display shows an arrow for the last of them."""
    letters = [chr(code) for code in range(0x20, 0x7F) if chr(code) not in '"\\']
    place = letters.index("a")
    desk.press(*EDIT.split(), "select")
    for key, step in (("down", -1), ("up", 1)):
        found = [desk.press(key)[1][1] for _ in letters]
        wanted = [
            letters[(place + step * turn) % len(letters)] for turn in range(1, len(letters) + 1)
        ]
        assert "".join(found) == "".join(wanted).replace("~", "→")
