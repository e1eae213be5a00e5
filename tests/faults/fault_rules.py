"""Which faults a controller can have and what each must trip, from its specification alone. It is
written from docs/safety.md and what the machines are, and knows nothing of the catalogue that is
judged by it. The machines of these tests are strong enough for every fault of a heater."""

from typing import Any

from heatwright.spec import Controller, facts_of

Rules = dict[str, str | None]  # by fault; None: nothing may trip
LEAK = "rising_while_off"
"""Unless the machine cools down into the band before: then the band is left, too."""
FULL_PERCENT = 100.0
BELOW_K = 5.0  # so far below its setpoint a machine is when its sensor fails


def _of(none: str = "", **by_rule: str) -> Rules:
    """Return faults that trip nothing, and others by the rule that each must trip."""
    found: Rules = dict.fromkeys(none.split())
    return found | {fault: rule for rule, faults in by_rule.items() for fault in faults.split()}


_CHIP = _of(
    "answers_damaged_in_bursts supply_interrupted_once slow_conversions",
    sensor_no_answer="unplugged", sensor_crc="damaged_answers", sensor_reset="failing_supply",
)  # fmt: skip
_THERMOCOUPLE = _of(
    "answers_damaged_in_bursts supply_interrupted_once",
    sensor_no_answer="unplugged data_shorted_to_supply no_clock failing_supply",
    sensor_short="data_shorted_to_ground", sensor_crc="damaged_answers",
    sensor_open="thermocouple_broken",
)  # fmt: skip
_ADC = _of(
    "intermittent_wire",
    sensor_open="open", sensor_short="shorted", sensor_stale="adc_hangs",
    sensor_range="beyond_the_cold_end beyond_the_hot_end",
)  # fmt: skip
_CIRCUIT = _ADC | _of(rise_rate="contact_corrodes insulation_leaks")
_SENSORS = {
    "ds18b20": _CHIP | _of(
        sensor_short="shorted_to_ground", sensor_no_answer="shorted_to_supply",
        sensor_reset="never_converts",
    ),
    "max6675": _THERMOCOUPLE,
    "max31855": _THERMOCOUPLE | _of(
        "slow_conversions", sensor_short="thermocouple_touches_ground thermocouple_touches_supply"
    ),
    "max31856": _THERMOCOUPLE | _CHIP | _of(
        sensor_short="thermocouple_beyond_supply", sensor_no_answer="orders_shorted_to_supply",
        rise_rate="thermocouple_broken_at_bias", sensor_range="chip_too_hot",
    ),
    "thermistor": _CIRCUIT,
    "rtd": _CIRCUIT,
    "analog": _ADC,
}  # fmt: skip
_CURRENT = _of(
    "heater_part_shorted",
    no_current="current_sensor_torn", current_while_off="current_sensor_stands",
    over_current="current_sensor_at_supply heater_shorted",
)  # fmt: skip
_ANY = _of(
    "small_jumps reset_button power_cut serial_flood healthy_noisy",
    under_temperature="frost", rise_rate="jump_up jump_down fallen_out", brown_out="brown_out",
    watchdog_reset="hung_main_loop hung_with_interrupts_off", settings_corrupt="eeprom_damaged",
    memory_damaged="setpoint_flipped",
)  # fmt: skip
_SELF_CHECKS = _of(
    flash_damaged="flash_flipped", flash_unsealed="flash_not_sealed",
    sequence_broken="duty_left_out", stack_overrun="stack_guard_flipped",
    ram_damaged="ram_cell_stuck", eeprom_worn="eeprom_decays",
    pin_held="pin_held",
)  # fmt: skip
_ON_ADC = {"thermistor", "rtd", "analog", "current"}
_RELAY = _of(
    relay_open="relay_dead relay_contact_shorted", relay_welded="relay_welded relay_contact_torn"
)
_PROGRAMS = _of(
    "power_cut_in_program power_cut_until_cold power_cut_in_pause",
    sensor_short="sensor_lost_in_program", watchdog_reset="hung_in_program",
    program_lags="heater_too_weak_for_program", memory_damaged="program_flipped",
)  # fmt: skip
_OPERATORS = {
    "lcd_keypad": _of(
        "key_stuck keys_at_random display_unplugged", sensor_short="select_stuck select_leaks"
    ),
    "gcode": _of(
        "host_out_of_bounds host_garbled host_only_asks",
        emergency_stop="host_stop host_stop_in_flood", master_lost="host_lost",
    ),
    "modbus_rtu": _of(
        "master_insists_on_heat master_out_of_bounds bus_damaged bus_of_other_format "
        "bus_of_other_slaves",
        master_lost="master_lost",
    ),
    "nextion": _of(
        "touch_display_unplugged touch_display_of_other_speed touch_display_floods "
        "touch_display_asks_too_much touched_at_random"
    ),
}  # fmt: skip


def rules_of(controller: Controller) -> Rules:
    (loop,) = controller.loops.values()
    kinds = {each.kind for each in controller.interfaces} & _OPERATORS.keys()
    found = _ANY | _healthy(controller, loop) | _SENSORS[controller.sensors[loop.sensor].kind]
    for kind in kinds:
        found |= _OPERATORS[kind]
    if kinds:
        found |= _of("record_cut_short", rise_rate="fallen_out_insisted")
    if any(facts_of(controller, name).countdown for name in controller.loops):
        found |= _of("countdown_ends")
    found |= _checks(controller)
    if controller.safety.relay_feedback:
        found |= _RELAY
    if controller.programs:
        found |= _PROGRAMS
        if controller.programs.on_fault == "pause":
            found |= _of(sensor_short="power_cut_in_interrupted_program")
    if loop.protection.on_for_at_most_s:
        found |= _of("switched_on_anew", on_too_long="left_on", memory_damaged="on_time_flipped")
    measured = getattr(controller.outputs[loop.heater], "current", None) is not None
    found |= _still(controller, loop, measured) | _heat(controller, loop, measured)
    return found | _effort(loop)


def _checks(controller: Controller) -> Rules:
    if not facts_of(controller).checked:
        return {}
    found = {**_SELF_CHECKS}
    if {each.kind for each in controller.sensors.values()} & _ON_ADC:
        found |= _of(adc_wrong="adc_reference_off")
    if facts_of(controller).proves_watchdog:
        found |= _of(clock_wrong="crystal_slow")
    return found


def _effort(loop: Any) -> Rules:
    """A power that does not fit the reading. A loop that switches shows an aged heater to 10."""
    effort = loop.protection.effort
    found: Rules = {}
    if effort is None or loop.cooler is not None:
        return {}
    if effort.low_percent is not None:
        found["reading_stands_high"] = "effort_low"
    if effort.high_percent is not None and loop.algorithm.kind == "pid":
        found |= {"heater_aged": "effort_high", "reading_drifts_low": "effort_high"}
    return found


def _healthy(controller: Controller, loop: Any) -> Rules:
    """Machines of all kinds, in winter and in summer, but no colder than a kelvin and a step of the
    sensor above the minimum."""
    least_c = loop.protection.minimum_c + 1 + controller.thermometers[loop.sensor].step_k
    rooms_c = (max(10, least_c), 35)
    spread = (0.7, 1.3)
    return {f"healthy_{c}C_{r}R_{a:.3g}degC": None for c in spread for r in spread for a in rooms_c}


def _still(controller: Controller, loop: Any, measured: bool) -> Rules:
    """A reading that stands still although heat is asked for, a heater that gives none. A PID asks
    for more while the reading stands still: `heating` waits for full power, `frozen` for more than
    holding needs."""
    heating, frozen = loop.protection.heating, loop.protection.frozen
    due_s: dict[str, float] = {}
    if frozen:
        due_s["sensor_frozen"] = _asked_s(loop, frozen.holding_percent) + frozen.for_s
    if heating:
        due_s["heating_failed"] = _asked_s(loop, FULL_PERCENT) + heating.within_s
    still = min(due_s, key=due_s.__getitem__)  # of two equal times the first
    rise = "no_current" if measured else "heating_failed" if heating else "sensor_frozen"
    below = bool(loop.protection.runaway.below_k) and not heating
    found: Rules = {"heater_open": rise, "heater_weak": rise}
    found["heat_lost"] = "runaway_below" if below else rise
    if loop.fan:
        found["fan_stopped"] = found["heat_lost"]
    if controller.sensors[loop.sensor].kind in {"thermistor", "rtd", "analog"}:
        found["adc_stuck"] = "no_current" if measured else still
    else:
        found["frozen"] = still
    if loop.cooler:
        found |= {"cooler_shorted": "heating_failed", "hung_while_cooling": "watchdog_reset"}
        found |= _of("cooler_dead heating_and_cooling_by_turns")
    return found


def _asked_s(loop: Any, percent: float) -> float:
    """Return how long a reading stands still until so much is asked for."""
    algorithm = loop.algorithm
    if algorithm.kind != "pid":
        return 0.0
    at_once_percent = algorithm.kp * BELOW_K + max(0.0, algorithm.integral.minimum_percent)
    missing_percent = max(0.0, percent - at_once_percent)
    return missing_percent / (algorithm.ki * BELOW_K)


def _heat(controller: Controller, loop: Any, measured: bool) -> Rules:
    """Heat that nobody asked for: its current tells first, then what the temperature reaches. A
    heater must have been off for `settle` before a rise counts."""
    protection = loop.protection
    settles = protection.runaway.for_s < protection.rising_while_off.settle_s
    band = "runaway_above" if settles else "rising_while_off"
    hot = "rise_rate" if _is_coarse(controller, loop) else "over_temperature"
    return {
        "switch_shorted_when_hot": "current_while_off" if measured else hot,
        "switch_shorted_in_band": "current_while_off" if measured else band,
        "switch_leaking": "current_while_off" if measured else LEAK, "heat_from_elsewhere": band,
        "fire": hot, **(_CURRENT if measured else {}),
    }  # fmt: skip


def _is_coarse(controller: Controller, loop: Any) -> bool:
    """Whether one step of the ADC near the maximum is more than a reading may move."""
    sensor, protection = controller.sensors[loop.sensor], loop.protection
    if not hasattr(sensor, "step_at_k"):
        return False
    step_k = sensor.step_at_k(protection.maximum_c, controller.board.mcu)
    return bool(step_k > protection.rise_rate_k_per_s * loop.period_s)
