"""Rules that a healthy machine breaks while it is warm: at rest, or after a power cut."""

from __future__ import annotations

from heatwright.spec.algorithms import Pid
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.machine import Machine
from heatwright.spec.heated_loop import HeatedLoop
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up


def frozen_rule_holds(machine: Machine, heated: HeatedLoop) -> Findings:
    """Find a rule `sensor_frozen` that a healthy machine breaks.

    At rest the reading stands still for as long as holding lasts, so the duty of that must not
    count; what is above it must have time to move the reading.
    """
    rule = machine.loop.protection.frozen
    if rule is None:
        return
    path = (*machine.path, "protection", "frozen")
    power_w, heat = heated.full_w, "full power"
    if isinstance(machine.loop.algorithm, Pid):
        takes_percent = 100 * heated.hold_w / heated.power_w
        if rule.holding_percent < takes_percent:
            yield Finding(
                (*path, "holding"),
                f"this plant takes {about(takes_percent)} % to hold "
                f"{celsius(heated.highest_c)}, and a reading that stands still there would be a "
                "fault",
                f"Use at least {rounded_up(takes_percent)} %, or delete it",
                machine.because_of,
            )
            return
        power_w = min(power_w, heated.power_w * rule.holding_percent / 100)
        heat = f"a little more than {number(rule.holding_percent)} %"
    if power_w <= heated.hold_w:
        return
    still_s = heated.longest_still_s(power_w) + heated.late_s
    if still_s > rule.for_s:
        yield Finding(
            (*path, "for"),
            f"at {heat} the reading of this plant, healthy, may stand still for "
            f"{duration(round(still_s, 1))}",
            f"Use more than {duration(round(still_s, 1))}",
            machine.because_of,
        )
