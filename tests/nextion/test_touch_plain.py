"""A machine without programs has a display too: on and off, a setpoint, gains, on the binary."""

import re

from hosted_kiln import SPEC
from kiln_desk import Built, KilnDesk
from rig.avr import whole
from rig.specs import spec_of

PLAIN = re.sub(r"programs:\n.*?interfaces:", "interfaces:", SPEC, flags=re.DOTALL)
ON_OFF = (
    PLAIN.replace("{kind: pid, kp: 7.6, ki: 0.026, kd: 51}", "{kind: on_off, hysteresis: 2 K}")
    .replace(", selectable: [K, S]", "")
    .replace("      maximum_adjustable: true\n", "")
)
BESIDE_MODBUS = PLAIN.replace("loop: chamber}", "loop: chamber, port: 1}\n  - {kind: modbus_rtu}")


class PlainDesk(KilnDesk):
    """The board, told what it is told at the start."""

    def __init__(self, text: str) -> None:
        super().__init__(Built(spec_of(text).controller, whole(text)))
        self.run(4.0)

    def tap(self, *names: str) -> None:
        """Touch, and see what comes of it in the next control steps."""
        super().tap(*names)
        self.run(3.0)


def test_a_setpoint_is_typed_and_held() -> None:
    plain = PlainDesk(PLAIN)
    assert plain.display.page == "main"
    plain.tap("bset", "bsp")
    plain.enter("45.")
    assert plain.shows("settings.sp.txt") == "45.0"
    plain.tap("back", "on")
    assert plain.read("loop_chamber.enabled") == 1
    assert plain.shows("main.set.val") == 45
    assert plain.shows("main.state.txt") == "on"
    assert plain.read("loop_chamber.duty_percent") > 0
    plain.tap("bstop", "yes")
    assert plain.read("loop_chamber.enabled") == 0
    assert plain.shows("main.on.val") == 0
    assert plain.display.errors == []


def test_gains_and_a_duty_by_hand() -> None:
    plain = PlainDesk(PLAIN)
    plain.tap("bdebug", "bkp")
    plain.enter("2.5")
    plain.tap("on", "bot")
    plain.enter("40")
    assert plain.read("settings.chamber_kp") == 2.5
    assert plain.shows("debug.kp.txt") == "2.5"
    assert plain.shows("debug.ot.val") == 40
    assert plain.display.errors == []


def test_a_switch_has_fewer_pages() -> None:
    simple = PlainDesk(ON_OFF)
    simple.tap("bdebug", "on")
    assert simple.read("loop_chamber.enabled") == 1
    simple.tap("back", "bset")
    assert simple.shows("settings.sp.txt") == "20.0"
    assert simple.display.errors == []


def test_on_another_port_beside_a_master() -> None:
    """The master's line stays its own; what starts disabled is told off before it is told on."""
    beside = PlainDesk(BESIDE_MODBUS)
    beside.tap("bdebug", "on")
    assert beside.read("loop_chamber.enabled") == 0
    assert beside.shows("debug.on.val") == 0
    beside.device.send("#2 0;")
    beside.run(3.0)
    beside.tap("on")
    assert beside.read("loop_chamber.enabled") == 1
    assert beside.shows("debug.on.val") == 1
