"""The condition that trips each rule, in words for a project's README."""

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.protection.relay import CONTACT_TICKS
from heatwright.spec import Controller, Proof, Protection, Spec, facts_of

READINGS = tuple(
    f"sensor_{cause}" for cause in ("no_answer", "short", "crc", "stale", "reset", "open", "range")
)
"""The rules that trip if a sensor gives no good reading."""


def limit(spec: Spec, rule: str) -> str:
    """Return the condition that trips `rule`; for each loop if the loops' conditions differ."""
    loops = spec.controller.loops
    anywhere = _limits_of_the_controller(spec)
    if rule in anywhere:
        return anywhere[rule]
    limits = {
        name: (_limits(spec, loop.protection) | _of_current(spec, name)).get(rule, "")
        for name, loop in loops.items()
    }
    if len(set(limits.values())) == 1:
        return next(iter(limits.values())) or "not used here"
    return "; ".join(f"{name}: {limit or 'not used'}" for name, limit in limits.items())


def _limits_of_the_controller(spec: Spec) -> dict[str, str]:
    """The conditions of the rules that belong to no loop, by the rule's id."""
    controller = spec.controller
    stop = {"emergency_stop": "`M112`"} if facts_of(controller).gcode else {}
    return (
        stop
        | _of_programs(controller)
        | _of_relay(controller)
        | _of_monitors(controller)
        | _of_proofs(controller)
        | _of_inputs(controller)
        | {
            "watchdog_reset": f"a reset after {quantity(controller.safety.watchdog_s, 's')} "
            "in which the main loop has not run",
            "brown_out": "a reset by the brown-out detector",
            "settings_corrupt": "the EEPROM has records, but no valid one",
            "memory_damaged": "a flipped bit in the latched fault, a setpoint, program or limit; "
            "it is found in the next control step",
            "ram_damaged": "one of two adjacent RAM cells does not keep what is written to it",
            "clock_wrong": "at the start, the watchdog, set to 16 ms, has three times in a row "
            "not reset within 12 to 24 ms",
            "eeprom_worn": "the cell that was last written or read now has another value",
            "adc_wrong": "the chip's own voltage reads more than a quarter wrong for a second",
            "flash_damaged": "its CRC is wrong, at the start or in the background",
            "sequence_broken": "a control step without all its tasks in their order, or ticks in "
            "which the heater gate has not run",
            "stack_overrun": "the guard bytes between stack and variables have changed",
            "flash_unsealed": "the program has no checksum, at the start",
            "pin_held": "a pin does not have its level, in three tests of that level in a row",
        }
    )


def _of_programs(controller: Controller) -> dict[str, str]:
    programs = controller.programs
    if programs is None or programs.hold_back is None:
        return {}
    waited = quantity(programs.hold_back.limit_s, "s")
    return {"program_lags": f"a segment has waited {waited} in total for a too cold machine"}


def _of_relay(controller: Controller) -> dict[str, str]:
    if controller.safety.relay_feedback is None:
        return {}
    late = f"{CONTACT_TICKS * TICK_MS} ms"
    return {
        "relay_welded": f"the contact reads closed {late} after the relay opened, or at the start",
        "relay_open": f"the contact reads open {late} after the relay closed",
    }


def _of_proofs(controller: Controller) -> dict[str, str]:
    limits = [
        f"no signal for {quantity(proof.within_s, 's')} that {name} turns{_speeds(proof)}"
        for name, proof in facts_of(controller).proofs.items()
    ]
    return {"fan_stopped": "; ".join(limits)} if limits else {}


def _of_inputs(controller: Controller) -> dict[str, str]:
    limits = [
        f"{name} is open for {quantity(each.for_s, 's')}"
        for name, each in facts_of(controller).tripping_inputs.items()
    ]
    return {"input_open": "; ".join(limits)} if limits else {}


def _speeds(proof: Proof) -> str:
    fan = proof.tachometer
    return f" at {fan.slowest_rpm:g} to {fan.fastest_rpm:g} rpm" if fan else ""


def _of_monitors(controller: Controller) -> dict[str, str]:
    limits = [f"{name}: {each.limit_c:g} °C or more" for name, each in controller.monitors.items()]
    return {"monitor_limit": "; ".join(limits)} if limits else {}


def _of_current(spec: Spec, name: str) -> dict[str, str]:
    """The conditions of the rules for the current of a loop's heater, by the rule's id."""
    current = facts_of(spec.controller, name).current
    if current is None:
        return {}
    return {
        "over_current": f"{quantity(current.over_a, 'A')} or more (mean)",
        "current_while_off": "a current for half a second, or five steps, while the heater is off",
        "no_current": "less than half of the current that fits its duty, for the same time",
    }


def _limits(spec: Spec, protection: Protection) -> dict[str, str]:
    """The condition of each rule of a loop, by the rule's id; all rules of readings share one."""
    stale = f"no good reading for {quantity(protection.stale_after_s, 's')}"
    limits = dict.fromkeys(READINGS, stale) | {
        "over_temperature": f"{protection.maximum_c:g} °C or more"
        + (", or a lower limit set by the operator" if protection.maximum_adjustable else ""),
        "under_temperature": f"{protection.minimum_c:g} °C or less",
        "rise_rate": f"a change of more than {quantity(protection.rise_rate_k_per_s, 'K/s')}",
    }
    if protection.frozen is not None:
        holding = protection.frozen.holding_percent
        heat = f"a duty above {quantity(holding, '%')}" if holding else "the heater on"
        limits["sensor_frozen"] = (
            f"exactly the same reading for {quantity(protection.frozen.for_s, 's')} with "
            f"{heat}, below the setpoint"
        )
    if protection.heating is not None:
        limits["heating_failed"] = (
            f"a rise of less than {quantity(protection.heating.rise_k, 'K')} in "
            f"{quantity(protection.heating.within_s, 's')} of full heat"
        )
    if protection.runaway is not None:
        time = quantity(protection.runaway.for_s, "s")
        limits["runaway_above"] = (
            f"{quantity(protection.runaway.above_k, 'K')} above the setpoint for {time}"
        )
        if protection.runaway.below_k is not None:
            limits["runaway_below"] = (
                f"{quantity(protection.runaway.below_k, 'K')} below the setpoint for {time}"
            )
    if protection.rising_while_off is not None:
        rising = protection.rising_while_off
        limits["rising_while_off"] = (
            f"a rise of {quantity(rising.rise_k, 'K')}, "
            f"from {quantity(rising.settle_s, 's')} after switching off"
        )
    return limits | _of_operation(spec, protection) | _of_comparison(protection)


def _of_operation(spec: Spec, protection: Protection) -> dict[str, str]:
    """The conditions of the rules about the host or master, and about the time on."""
    limits = {}
    if protection.master_lost_after_s is not None:
        silence = quantity(protection.master_lost_after_s, "s")
        sign = "request" if facts_of(spec.controller).gcode is None else "line from the host"
        limits["master_lost"] = f"no {sign} for {silence} while the loop is on"
    if protection.on_for_at_most_s is not None:
        limits["on_too_long"] = (
            f"on for {quantity(protection.on_for_at_most_s, 's')} without being switched off"
        )
    return limits


def _of_comparison(protection: Protection) -> dict[str, str]:
    """The conditions of the rules that compare the reading with a second sensor, or the power."""
    limits = {}
    if protection.agreement is not None:
        limits["sensors_disagree"] = (
            f"the sensors differ by more than {quantity(protection.agreement.within_k, 'K')} for "
            f"{quantity(protection.agreement.for_s, 's')}"
        )
    effort = protection.effort
    if effort is not None:
        for rule, bound, share, season in (
            ("effort_high", "more", effort.high_percent, "winter"),
            ("effort_low", "less", effort.low_percent, "summer"),
        ):
            if share is not None:
                limits[rule] = (
                    f"{bound} than {quantity(share, '%')} of the power that holds the reading in "
                    f"{season}, for {quantity(effort.for_s, 's')} while the reading is constant"
                )
    return limits
