"""What trips each rule, in the words of a project's README."""

from __future__ import annotations

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.protection.relay import CONTACT_TICKS
from heatwright.spec import Controller, Proof, Protection, Spec, proofs
from heatwright.spec.commands import gcode_of
from heatwright.spec.inputs import tripping

READINGS = tuple(
    f"sensor_{cause}" for cause in ("no_answer", "short", "crc", "stale", "reset", "open", "range")
)
"""The rules of a sensor that gives no good reading."""


def limit(spec: Spec, rule: str) -> str:
    """What trips `rule`: once if all loops agree, else loop by loop."""
    loops = spec.controller.loops
    anywhere = _limits_of_the_controller(spec)
    if rule in anywhere:
        return anywhere[rule]
    limits = {
        name: (_limits(spec, loop.protection) | _of_current(spec, loop.heater)).get(rule, "")
        for name, loop in loops.items()
    }
    if len(set(limits.values())) == 1:
        return next(iter(limits.values())) or "not used here"
    return "; ".join(f"{name}: {limit or 'not used'}" for name, limit in limits.items())


def _limits_of_the_controller(spec: Spec) -> dict[str, str]:
    """What trips the rules that belong to no loop, by the rule's id."""
    controller = spec.controller
    stop = {"emergency_stop": "`M112`"} if gcode_of(controller) else {}
    return (
        stop
        | _of_programs(controller)
        | _of_relay(controller)
        | _of_monitors(controller)
        | _of_proofs(controller)
        | _of_inputs(controller)
        | {
            "watchdog_reset": f"a reset after {quantity(controller.safety.watchdog_s, 's')} "
            "without the main loop",
            "brown_out": "a reset by the brown-out detector",
            "settings_corrupt": "records in the EEPROM, and none of them valid",
            "memory_damaged": "a flipped bit of the latch, of a setpoint or of a limit; it is seen "
            "in the next control step",
            "ram_damaged": "a cell of the RAM, or its neighbour, does not keep what is written",
            "clock_wrong": "three times in turn the watchdog, set to 16 ms, has not reset within "
            "12 to 24 ms, at the start",
            "eeprom_worn": "the cell written or read last now reads as something else",
            "adc_wrong": "the chip's own voltage is measured more than a quarter off for a second",
            "flash_damaged": "its CRC is another one, at the start or in the background",
            "sequence_broken": "a control step without all its duties in order, or ticks in which "
            "the heaters' gate has not run",
            "stack_overrun": "the bytes between stack and variables have changed",
            "flash_unsealed": "no checksum in the program, at the start",
            "pin_held": "a pin that is not at its level, at three looks in turn at that level",
        }
    )


def _of_programs(controller: Controller) -> dict[str, str]:
    programs = controller.programs
    if programs is None or programs.hold_back is None:
        return {}
    waited = quantity(programs.hold_back.limit_s, "s")
    return {"program_lags": f"a segment has waited {waited} in all for a machine that is too cold"}


def _of_relay(controller: Controller) -> dict[str, str]:
    if controller.safety.relay_feedback is None:
        return {}
    late = f"{CONTACT_TICKS * TICK_MS} ms"
    return {
        "relay_welded": f"the contact says closed {late} after it was opened, and at the start",
        "relay_open": f"the contact says open {late} after it was closed",
    }


def _of_proofs(controller: Controller) -> dict[str, str]:
    limits = [
        f"nothing proves for {quantity(proof.within_s, 's')} that {name} turns{_speeds(proof)}"
        for name, proof in proofs(controller).items()
    ]
    return {"fan_stopped": "; ".join(limits)} if limits else {}


def _of_inputs(controller: Controller) -> dict[str, str]:
    limits = [
        f"{name} is open for {quantity(each.for_s, 's')}"
        for name, each in tripping(controller).items()
    ]
    return {"input_open": "; ".join(limits)} if limits else {}


def _speeds(proof: Proof) -> str:
    fan = proof.tachometer
    return f" at {fan.slowest_rpm:g} to {fan.fastest_rpm:g} rpm" if fan else ""


def _of_monitors(controller: Controller) -> dict[str, str]:
    limits = [f"{name}: {each.limit_c:g} °C or more" for name, each in controller.monitors.items()]
    return {"monitor_limit": "; ".join(limits)} if limits else {}


def _of_current(spec: Spec, heater: str) -> dict[str, str]:
    """What trips the rules of a heater's current, by the rule's id."""
    current = getattr(spec.controller.outputs[heater], "current", None)
    if current is None:
        return {}
    return {
        "over_current": f"{quantity(current.over_a, 'A')} or more, in the mean",
        "current_while_off": "a current for half a second, or five steps, after it went off",
        "no_current": "less than half of the current that its duty must bring, for as long",
    }


def _more_heat(holding_percent: float) -> str:
    return f"more heat than {quantity(holding_percent, '%')}" if holding_percent else "heat"


def _limits(spec: Spec, protection: Protection) -> dict[str, str]:
    """What trips each rule of a loop, by the rule's id; the readings' rules share one limit."""
    stale = f"no good reading for {quantity(protection.stale_after_s, 's')}"
    limits = dict.fromkeys(READINGS, stale) | {
        "over_temperature": f"{protection.maximum_c:g} °C or more"
        + (", or what the operator has lowered it to" if protection.maximum_adjustable else ""),
        "under_temperature": f"{protection.minimum_c:g} °C or less",
        "rise_rate": f"a change of more than {quantity(protection.rise_rate_k_per_s, 'K/s')}",
    }
    if protection.frozen is not None:
        limits["sensor_frozen"] = (
            f"one and the same reading for {quantity(protection.frozen.for_s, 's')} of "
            f"{_more_heat(protection.frozen.holding_percent)} below the setpoint"
        )
    if protection.heating is not None:
        limits["heating_failed"] = (
            f"less than {quantity(protection.heating.rise_k, 'K')} in "
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
    return limits | _of_people(spec, protection) | _of_second(protection)


def _of_people(spec: Spec, protection: Protection) -> dict[str, str]:
    """What trips the rules about who asks for heat."""
    limits = {}
    if protection.master_lost_after_s is not None:
        silence = quantity(protection.master_lost_after_s, "s")
        asked = "request" if gcode_of(spec.controller) is None else "line from the host"
        limits["master_lost"] = f"no {asked} for {silence} while the loop is on"
    if protection.on_for_at_most_s is not None:
        limits["on_too_long"] = (
            f"on for {quantity(protection.on_for_at_most_s, 's')} without being switched off"
        )
    return limits


def _of_second(protection: Protection) -> dict[str, str]:
    """What trips the rules that compare the reading with something else: a sensor, the power."""
    limits = {}
    if protection.agreement is not None:
        limits["sensors_disagree"] = (
            f"more than {quantity(protection.agreement.within_k, 'K')} apart for "
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
                    f"{bound} than {quantity(share, '%')} of the power that the plant takes for a "
                    f"reading in {season}, for {quantity(effort.for_s, 's')} in which that stands"
                )
    return limits
