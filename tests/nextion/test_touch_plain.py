"""A machine without programs has a display too: on and off, a setpoint, gains, on the binary."""

import re
from typing import Any

import pytest
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


ON = "loop_chamber.enabled"

DEEDS: dict[str, tuple[str, list[tuple[str, dict[str, Any]]]]] = {
    "a setpoint is typed and held": (PLAIN, [
        ("", {"page": "main"}),
        ("bset bsp; enter 45.", {"settings.sp.txt": "45.0"}),
        ("back on", {ON: 1, "main.set.val": 45, "main.state.txt": "on",
                     "loop_chamber.duty_percent": 100}),
        ("bstop yes", {ON: 0, "main.on.val": 0}),
    ]),
    "gains and a duty by hand": (PLAIN, [
        ("bdebug bkp; enter 2.5; on bot; enter 40",
         {"settings.chamber_kp": 2.5, "debug.kp.txt": "2.5", "debug.ot.val": 40}),
    ]),
    "a switch has fewer pages": (ON_OFF, [
        ("bdebug on", {ON: 1}), ("back bset", {"settings.sp.txt": "20.0"}),
    ]),
    # The master's line stays its own; what starts disabled is told off before it is told on.
    "on another port beside a master": (BESIDE_MODBUS, [
        ("bdebug on", {ON: 0, "debug.on.val": 0}),
        ("order 2 0; on", {ON: 1, "debug.on.val": 1}),
    ]),
}  # fmt: skip
"""Of which machine; what is done with the display, and what is seen then."""


@pytest.mark.parametrize("name", DEEDS)
def test_a_machine_without_programs(name: str) -> None:
    text, steps = DEEDS[name]
    desk = KilnDesk(Built(spec_of(text).controller, whole(text)))
    desk.run(4.0)
    for deeds, seen in steps:
        desk.do(deeds)
        desk.run(1.5)
        assert {each: desk.look(each) for each in seen} == seen, deeds
    assert text == BESIDE_MODBUS or desk.display.errors == []
