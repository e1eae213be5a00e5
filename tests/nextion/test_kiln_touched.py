"""Every order of the display, given by touching its pages, on the binary.

A machine without programs has a display too: on and off, a setpoint, gains. And the line may have
other speeds and ports.
"""

import re
from typing import Any

import numpy as np
import pytest
from hosted_kiln import SPEC
from rig.firmware import changed, device_of

from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.interfaces.nextion.codes import Code
from heatwright.sim.interfaces.nextion.screen import draw, rgb
from heatwright.spec.boards import BOARDS
from heatwright.spec.nextion import display_pages
from heatwright.spec.nextion.parts import GROUND, RED

IDLE, RUNNING, PAUSED, RETURNING = range(4)
INTERRUPTED = 5  # states of a program
ROOM_C = 20.0
K, S = 3, 6  # codes of thermocouples (MAX31856 data sheet, configuration register 1)
SAVED = "wait 30"  # settings are kept within this time after they were changed
SETPOINT, MAXIMUM = "settings.chamber_setpoint_c", "settings.chamber_maximum_c"
TYPE, ENABLED = "settings.chamber_thermocouple", "loop_chamber.enabled"
DUTY, MODE = "loop_chamber.duty_percent", "loop_chamber.mode"
STATE, CLOCK, START = "program.state", "program.clock", "bprog s1"

TOUCHES: dict[str, list[tuple[str, dict[str, Any]]]] = {
    "8 a program is started": [
        (START, {"page": "main", STATE: RUNNING, "program.number": 1, ENABLED: 1})],
    "9 it is paused, and goes on": [
        (f"{START}; wait 10; bt1", {STATE: PAUSED, ENABLED: 0, "bt1.val": 0}),
        ("bt1", {STATE: RETURNING, ENABLED: 1, "bt1.val": 1})],
    "10 go here": [
        (START, {}),
        ("bpoints g3", {"page": "main", "program.segment": 4, STATE: RETURNING, "point.val": 4,
                        "program.setpoint_c": 800})],
    "13 and 7 a segment is changed": [
        ("bprog b1; wait 1; t1",
         {"page": "point", "k.txt": "time", "m.txt": "1h00", "t.txt": "540"}),
        ("t clear d3 d10 d10 d9 d4 m less less d2 ok",
         {"page": "points", "row1": "time 1h09 400.5"})],
    "7 a rate": [
        ("bprog b1; wait 1; t8 k1 m clear d6 d4 d10 t clear d5 d10 d10 ok", {"row8": "K/h 150 600"})
    ],
    "7 as fast as it can": [
        ("bprog b1; wait 1; t8 k2 m clear t clear d5 d10 d10 ok", {"row8": "fast  600"})],
    "7 until somebody says so": [
        ("bprog b1; wait 1; t8 k3 m clear t clear ok", {"row8": "until"})],
    "7 a hold": [("bprog b1; wait 1; t8 k4 m clear d6 d7 t clear ok", {"row8": "hold 0h12"})],
    "7 hours and minutes": [
        ("bprog b1; wait 1; t8 k4 m clear d6 d7 hours d7 d10 t clear ok", {"row8": "hold 12h20"}),
        ("t8 k1 t d5 ok", {"row8": "hold 12h20"})],
    "7 the source's own example in an empty place is there after a power cut, and runs": [
        ("bprog b2; wait 1; order 7 1,20,600:2,40,300:3,60,300:4,0,0:; pname c00 c11 space c39 ok; "
         "wait 10", {"pname.txt": "al 9"}),
        ("power; bprog", {"name2.txt": "al 9"}),
        ("b2", {"row1": "time 0h20 600", "row2": "time 0h40 300", "k3.txt": "hold",
                "m3.txt": "1h00", "row4": ""}),
        ("back bprog s2", {STATE: RUNNING, "program.number": 2, "program.segments": 3})],
    "7 the end of a program is moved": [
        ("bprog b1; wait 1; t5 end", {"k4.txt": "hold", "k5.txt": "", "k6.txt": ""})],
    "17 a stop is asked for": [
        (f"{START}; bstop no", {STATE: RUNNING}),
        ("bstop yes", {STATE: IDLE, ENABLED: 0, "page": "main"})],
    "18 the operator goes on": [(f"{START}; wait 3; bskip", {"program.segment": 2})],
    "2 the loop is switched": [
        ("bdebug on", {ENABLED: 1, "on.val": 1}), ("on", {ENABLED: 0, "on.val": 0})],
    "3 the setpoint": [
        ("bset bsp; enter 321.5", {"page": "settings", SETPOINT: 321.5, "sp.txt": "321.5"})],
    "4 the output by hand, until the loop takes it back": [
        ("bdebug on bot; enter 42; wait 1", {"page": "debug", DUTY: 42, MODE: 1, "ot.val": 42}),
        ("order 2 1; wait 1", {MODE: 0})],
    "20 the critical temperature is kept, and only ever lowered": [
        (f"bset bcrit; enter 900; {SAVED}", {MAXIMUM: 900}),
        ("bcrit; enter 1200", {MAXIMUM: 900}),
        ("power", {MAXIMUM: 900})],
    "15 the thermocouple": [
        ("wire S; bset btype", {"typeK.txt": "K  1300 °C", "typeS.txt": "S  1750 °C"}),
        ("typeS", {TYPE: S, "thermo.type.txt": "S"}),
        (f"{SAVED}; power", {TYPE: S})],
    **{
        f"{number} and 22 gains are set and kept": [
            (f"bdebug b{gain}; enter 1.25", {setting: 1.25, f"{gain}.txt": "1.25"}),
            (f"keep; {SAVED}; power", {setting: 1.25}),
        ]
        for number, gain in ((5, "kp"), (6, "ki"), (19, "kd"))
        for setting in [f"settings.chamber_{gain}"]
    },
    "11 a segment is marked": [("bprog b1; p4", {"points_marked": 4})],
    "12 and 16 a fault, its page, the list, the acknowledgement, and on from the kept place": [
        (f"{START}; wait 3; break; wait 8",
         {"fault.code": 17, "page": "fault17", STATE: INTERRUPTED, ENABLED: 0,
          "program.segment": 1, CLOCK: 10}),
        ("list", {"page": "faults", "l1.txt": "E17 SENSOR OPEN  20.0 C  0d 00:00"}),
        ("mend; wait 3; ack", {"fault.code": 0}),
        ("back; wait 20", {"page": "main", "ERROR.en": 0, "main.bco": GROUND,
                           STATE: INTERRUPTED, ENABLED: 0, "program.segment": 1, CLOCK: 10}),
        ("bt1", {STATE: RUNNING, ENABLED: 1, "program.segment": 1, CLOCK: 11})],
}  # fmt: skip
"""What is done with the display, and what is seen then."""


class KilnDesk:
    """A kiln at the temperature of the room that is powered on, with its display on its line.

    device -- the board.
    """

    def __init__(self, spec: str = "kiln") -> None:
        self.device = device_of(spec)

    @property
    def display(self) -> Nextion:
        return self.device.display

    def run(self, seconds: float) -> None:
        self.device.sense("chamber", ROOM_C)
        self.device.advance(self.device.time_s + seconds)
        self.device.feed()

    def tap(self, *names: str) -> None:
        for name in names:
            self.display.tap(name)
            self.run(1.0)

    def do(self, deeds: str) -> None:
        """Do what stands there between semicolons, with time for what comes of it.

        `enter 12.5` in place of what is shown, `order 2 1`, `wait 30` (seconds), `power` (cut and
        given back); `wire S`, `break` and `mend` the thermocouple; all other words are touched.
        """
        for deed in deeds.split("; "):
            verb, _, rest = deed.partition(" ")
            match verb:
                case "enter":
                    keys = {key: f"d{place}" for place, key in enumerate("789456123.0-")}
                    self.tap("clear", *(keys[character] for character in rest), "ok")
                case "order":
                    self.display.send(f"#{rest};")
                case "wait":
                    self.run(float(rest))
                case "power":
                    self.device.power_cycle()
                    self.run(2.0)
                case "wire":
                    self.device.sensors["chamber"].wire = rest
                case "break" | "mend":
                    self.device.sensors["chamber"].faults.open = verb == "break"
                case _:
                    self.tap(*deed.split())
        self.run(2.0)

    def look(self, name: str) -> Any:
        """Return the page that is shown, a row of a program, a variable, or what a field shows."""
        if name == "page":
            return self.display.page
        if name.startswith("row"):
            return " ".join(self.look(f"{column}{name[3:]}.txt") for column in "kmt").strip()
        shown = name.endswith((".txt", ".val", ".en", ".bco"))
        return self.display.value(name) if shown else self.device.read(name).item()


@pytest.fixture
def desk() -> KilnDesk:
    made = KilnDesk()
    made.run(2.0)
    return made


@pytest.mark.parametrize("name", TOUCHES)
def test_touched(desk: KilnDesk, name: str) -> None:
    for deeds, seen in TOUCHES[name]:
        desk.do(deeds)
        assert {each: desk.look(each) for each in seen} == seen, deeds
        assert in_flight(desk), deeds


def in_flight(desk: KilnDesk) -> bool:
    """Return whether all errors since the last call were one instruction for a page just left.

    The operator may be there again: what it names is a component of its page.
    """
    errors = [*desk.display.errors]
    desk.display.errors.clear()
    named = {
        f"{page.name}.{component.name}"
        for page in display_pages(desk.device._controller)
        for component in page.components
    }
    return not errors or (
        len(errors) == 1
        and errors[0][1] is Code.INVALID_VARIABLE
        and errors[0][0].rpartition(".")[0] in named
    )


def reds(desk: KilnDesk) -> list[float]:
    found = []
    for _ in range(8):
        desk.run(0.25)
        found.append(float((np.asarray(draw(desk.display.display)) == rgb(RED)).all(axis=2).mean()))
    return found


def test_a_fault_has_the_whole_main_page_flash(desk: KilnDesk) -> None:
    """More than half of its pixels, in time with the timer; and nothing once it is acknowledged."""
    calm = reds(desk)[0]
    desk.do("break; wait 8; back")
    flashing = reds(desk)
    assert max(calm, *flashing) < 1.0
    assert sum(red > 0.5 + calm for red in flashing) == sum(red == calm for red in flashing) == 4
    desk.do("mend; wait 3; order 16; wait 1")
    assert set(reds(desk)) == {calm}


PLAIN = re.sub(r"programs:\n.*?interfaces:", "interfaces:", SPEC, flags=re.DOTALL)
ON_OFF = (
    PLAIN.replace("{kind: pid, kp: 7.6, ki: 0.026, kd: 51}", "{kind: on_off, hysteresis: 2 K}")
    .replace(", selectable: [K, S]", "")
    .replace("maximum_adjustable: true, ", "")
)
BESIDE_MODBUS = PLAIN.replace("loop: chamber}", "loop: chamber, port: 1}\n  - {kind: modbus_rtu}")
DEEDS: dict[str, tuple[str, list[tuple[str, dict[str, Any]]]]] = {
    "a setpoint is typed and held": (PLAIN, [
        ("", {"page": "main"}),
        ("bset bsp; enter 45.", {"settings.sp.txt": "45.0"}),
        ("back on", {ENABLED: 1, "main.set.val": 45, "main.state.txt": "on",
                     "loop_chamber.duty_percent": 100}),
        ("bstop yes", {ENABLED: 0, "main.on.val": 0})]),
    "gains and a duty by hand": (PLAIN, [
        ("bdebug bkp; enter 2.5; on bot; enter 40",
         {"settings.chamber_kp": 2.5, "debug.kp.txt": "2.5", "debug.ot.val": 40})]),
    "a switch has fewer pages": (ON_OFF, [
        ("bdebug on", {ENABLED: 1}), ("back bset", {"settings.sp.txt": "20.0"})]),
    # The master's line stays its own; a touch on ON needs no OFF before it, as a key does not.
    "on another port beside a master": (BESIDE_MODBUS, [
        ("bdebug on", {ENABLED: 1, "debug.on.val": 1}),
        ("order 2 0", {ENABLED: 0, "debug.on.val": 0}), ("on", {ENABLED: 1})]),
}  # fmt: skip
"""The machine; what is done with the display, and what is seen then."""


@pytest.mark.parametrize("name", DEEDS)
def test_a_machine_without_programs(name: str) -> None:
    text, steps = DEEDS[name]
    desk = KilnDesk(text)
    desk.run(4.0)
    for deeds, seen in steps:
        desk.do(deeds)
        desk.run(1.5)
        assert {each: desk.look(each) for each in seen} == seen, deeds
    assert text == BESIDE_MODBUS or desk.display.errors == []


@pytest.mark.parametrize("own", [2400, 9600, 57_600, 250_000])
def test_a_display_of_another_speed_is_found(own: int) -> None:
    """Within seconds after the power-up; what it says before is no order. It keeps the new one."""
    desk = KilnDesk()
    desk.display.set_speed(own)
    desk.run(2.0)
    desk.display.send("#8 1;")
    desk.run(0.5)
    assert (desk.display.line.baud, desk.look(STATE)) == (own, IDLE)
    desk.run(8.0)
    assert (desk.display.line.baud, desk.look("temp.val")) == (115_200, 20)
    desk.do(START)
    assert desk.look(STATE) == RUNNING
    desk.do("power")
    assert (desk.display.line.baud, desk.look("temp.val")) == (115_200, 20)


@pytest.mark.parametrize(("port", "baud"), [(2, 115_200), (3, 9_600)])
def test_another_port_another_speed(port: int, baud: int) -> None:
    """With the log on port 1 and nothing on port 0; a slow line takes longer than two ticks."""
    line = f"{{kind: nextion, port: {port}, baud: {baud},"
    text = changed("kiln", ("{kind: nextion, baud: 115200,", line))
    desk = KilnDesk(text)
    desk.run(4.0)
    assert BOARDS["mega2560"].uarts[port].number == desk.device.uart == port
    assert desk.look("main.temp.val") == 20
    assert desk.display.errors == []
    desk.tap("bprog", "s1")
    desk.run(1.0)
    assert desk.look("program.state") == RUNNING
    late = [text for text, _ in desk.display.errors]
    assert all(text.startswith("programs.") for text in late), "said as its page was left"
