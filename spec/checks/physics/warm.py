"""Rules that trip on a healthy machine while it is warm: in steady state, or after a power cut."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.physics.machine import Machine
from heatwright.spec.physics.heated_loop import HeatedLoop
from heatwright.spec.quantity import about, celsius, duration, number, rounded_up


def frozen_rule_holds(machine: Machine, heated: HeatedLoop) -> Findings:
    """Find a rule `sensor_frozen` that trips on a healthy machine.

    In the steady state the reading is constant, so the rule must ignore the duty that holds it. At
    a higher duty the rule must wait until the reading can have changed.
    """
    rule = machine.loop.protection.frozen
    if rule is None:
        return
    path = (*machine.path, "protection", "frozen")
    power_w, heat = heated.full_w, "full power"
    if machine.loop.algorithm.continuous:
        takes_percent = 100 * heated.hold_w / heated.power_w
        if rule.holding_percent < takes_percent:
            yield Finding(
                (*path, "holding"),
                f"this plant needs {about(takes_percent)} % to hold "
                f"{celsius(heated.highest_c)}, and a constant reading there would be a "
                "fault",
                f"Use at least {rounded_up(takes_percent)} %, or delete holding",
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
            f"at {heat} the reading of this healthy plant may be constant for "
            f"{duration(round(still_s, 1))}",
            f"Use more than {duration(round(still_s, 1))}",
            machine.because_of,
        )


def heating_rule_holds_warm(machine: Machine, heated: HeatedLoop) -> Findings:
    """Find a rule `heating_failed` that trips on a healthy machine which is warm at the start.

    After a power cut the element is cold and the reading falls at first, but the rule measures the
    rise from the reading before. `heating_rule_holds` checks a cold machine.
    """
    rule = machine.loop.protection.heating
    if rule is None:
        return
    longest_s, from_c = heated.slowest_rise(rule.rise_k, machine.loop.algorithm.full_beyond_k)
    longest_s += heated.late_s
    if longest_s > rule.within_s:
        yield machine.finding(
            ("protection", "heating", "within"),
            f"after a power cut this healthy plant restarts at {about(from_c)} °C with a cold "
            f"heater, and at full power it needs {duration(round(longest_s))} for a rise of "
            f"{number(rule.rise_k)} K",
            f"Use more than {duration(round(longest_s))}, or a smaller rise",
        )
