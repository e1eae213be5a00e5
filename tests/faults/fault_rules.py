"""Which faults a controller can have and what each must trip, from its specification alone.

It is written from docs/safety.md and what the machines are, and knows nothing of the catalogue
that is judged by it. The machines of these tests are strong enough for every fault of a heater.
"""

from typing import Any

from heatwright.spec import Controller

Rules = dict[str, str | None]
"""By fault; None: nothing may trip."""


def _none(*names: str) -> Rules:
    return dict.fromkeys(names)


_CHIP: Rules = {
    "unplugged": "sensor_no_answer",
    "damaged_answers": "sensor_crc",
    "failing_supply": "sensor_reset",
    **_none("answers_damaged_in_bursts", "supply_interrupted_once", "slow_conversions"),
}
_CIRCUIT: Rules = {
    "open": "sensor_open",
    "shorted": "sensor_short",
    "beyond_the_cold_end": "sensor_range",
    "beyond_the_hot_end": "sensor_range",
    "adc_hangs": "sensor_stale",
    "intermittent_wire": None,
    "contact_corrodes": "rise_rate",
    "insulation_leaks": "rise_rate",
}
_SENSORS: dict[str, Rules] = {
    "ds18b20": _CHIP
    | {
        "shorted_to_ground": "sensor_short",
        "shorted_to_supply": "sensor_no_answer",
        "never_converts": "sensor_reset",
    },
    "max31856": _CHIP
    | {
        "data_shorted_to_ground": "sensor_short",
        "data_shorted_to_supply": "sensor_no_answer",
        "orders_shorted_to_supply": "sensor_no_answer",
        "no_clock": "sensor_no_answer",
        "thermocouple_broken": "sensor_open",
        "thermocouple_broken_at_bias": "rise_rate",
        "thermocouple_beyond_supply": "sensor_short",
        "chip_too_hot": "sensor_range",
    },
    "thermistor": _CIRCUIT,
    "rtd": _CIRCUIT,
}
_CURRENT: Rules = {
    "current_sensor_torn": "no_current",
    "current_sensor_at_supply": "over_current",
    "current_sensor_stands": "current_while_off",
    "heater_shorted": "over_current",
    "heater_part_shorted": None,
}
_ANY: Rules = {
    "frost": "under_temperature",
    "jump_up": "rise_rate",
    "jump_down": "rise_rate",
    "small_jumps": None,
    "fallen_out": "rise_rate",
    "hung_main_loop": "watchdog_reset",
    "hung_with_interrupts_off": "watchdog_reset",
    "brown_out": "brown_out",
    "reset_button": None,
    "power_cut": None,
    "eeprom_damaged": "settings_corrupt",
    "serial_flood": None,
    "healthy_noisy": None,
}
_HEALTHY = _none(
    *(f"healthy_{c}C_{r}R_{a}degC" for c in (0.7, 1.3) for r in (0.7, 1.3) for a in (10, 35))
)
_RELAY: Rules = {
    "relay_dead": "relay_open",
    "relay_contact_shorted": "relay_open",
    "relay_welded": "relay_welded",
    "relay_contact_torn": "relay_welded",
}
_PROGRAMS: Rules = {
    "sensor_lost_in_program": "sensor_short",
    "hung_in_program": "watchdog_reset",
    "heater_too_weak_for_program": "program_lags",
    **_none("power_cut_in_program", "power_cut_until_cold", "power_cut_in_pause"),
}
_OPERATORS: dict[str, Rules] = {
    "lcd_keypad": {
        **_none("key_stuck", "keys_at_random", "display_unplugged"),
        "select_stuck": "sensor_short",
    },
    "gcode": {
        "host_stop": "emergency_stop",
        "host_stop_in_flood": "emergency_stop",
        **_none("host_out_of_bounds", "host_garbled"),
    },
    "modbus_rtu": {
        "master_lost": "master_lost",
        **_none("master_insists_on_heat", "master_out_of_bounds"),
        **_none("bus_damaged", "bus_of_other_format", "bus_of_other_slaves"),
    },
    "nextion": _none(
        "touch_display_unplugged", "touch_display_of_other_speed", "touch_display_floods",
        "touch_display_asks_too_much", "touched_at_random",
    ),
}  # fmt: skip


def rules_of(controller: Controller) -> Rules:
    """Return what each fault of a controller with one loop must trip."""
    (loop,) = controller.loops.values()
    kinds = {each.kind for each in controller.interfaces} & _OPERATORS.keys()
    found = _ANY | _HEALTHY | _SENSORS[controller.sensors[loop.sensor].kind]
    for kind in kinds:
        found |= _OPERATORS[kind]
    if kinds:
        found |= _none("record_cut_short")
    if controller.safety.relay_feedback:
        found |= _RELAY
    if controller.programs:
        found |= _PROGRAMS
    measured = getattr(controller.outputs[loop.heater], "current", None) is not None
    return found | _still(controller, loop, measured) | _heat(controller, loop, measured)


def _still(controller: Controller, loop: Any, measured: bool) -> Rules:
    """A reading that stands still although heat is asked for, a heater that gives none.

    Of two equal times that of `frozen` ends first: it does not wait for full power.
    """
    heating, frozen = loop.protection.heating, loop.protection.frozen
    sooner = heating is None or (frozen is not None and frozen.for_s <= heating.within_s)
    rise = "no_current" if measured else "heating_failed"
    found: Rules = {}
    if controller.sensors[loop.sensor].kind in {"thermistor", "rtd"}:
        found["adc_stuck"] = rise
    else:
        found["frozen"] = "sensor_frozen" if sooner else "heating_failed"
    if heating:
        found |= {"heater_open": rise, "heater_weak": rise}
        found |= {"fan_stopped": "heating_failed"} if loop.fan else {}
    if loop.protection.runaway.below_k:
        found["heat_lost"] = rise if heating else "runaway_below"
    if loop.cooler:
        found |= {"cooler_shorted": "heating_failed", "hung_while_cooling": "watchdog_reset"}
        found |= _none("cooler_dead", "heating_and_cooling_by_turns")
    return found


def _heat(controller: Controller, loop: Any, measured: bool) -> Rules:
    """Heat that nobody asked for: its current tells first, then what the temperature reaches.

    A heater must have been off for `settle` before a rise counts.
    """
    protection = loop.protection
    settles = protection.runaway.for_s < protection.rising_while_off.settle_s
    band = "runaway_above" if settles else "rising_while_off"
    hot = "rise_rate" if _is_coarse(controller, loop) else "over_temperature"
    return {
        "switch_shorted_when_hot": "current_while_off" if measured else hot,
        "switch_shorted_in_band": "current_while_off" if measured else band,
        "switch_leaking": "current_while_off" if measured else "rising_while_off",
        "heat_from_elsewhere": band,
        "fire": hot,
        **(_CURRENT if measured else {}),
    }


def _is_coarse(controller: Controller, loop: Any) -> bool:
    """Whether one step of the ADC near the maximum is more than a reading may move."""
    sensor, protection = controller.sensors[loop.sensor], loop.protection
    if not hasattr(sensor, "step_at_k"):
        return False
    step_k = sensor.step_at_k(protection.maximum_c, controller.board.mcu)
    return bool(step_k > protection.rise_rate_k_per_s * loop.period_s)
