"""What the controller checks of itself, as IEC 60730 class B asks."""

from __future__ import annotations

from heatwright.spec.controller import Controller

FLASH_BYTES_A_TICK = 2
"""Of the flash, taken into its CRC in each tick of 10 ms."""

SELF_CHECK_RULES = (
    "ram_damaged",
    "flash_damaged",
    "clock_wrong",
    "eeprom_worn",
    "sequence_broken",
    "adc_wrong",
    "stack_overrun",
    "flash_unsealed",
)
"""Ids of the rules that come with the self-checks; the ADC's where a sensor is on it."""


def self_checked(controller: Controller) -> bool:
    """Tell whether the controller checks itself."""
    return controller.safety.self_checks


def measures_known_voltage(controller: Controller) -> bool:
    """Tell whether a voltage that is known is measured beside what is on the ADC."""
    return self_checked(controller) and bool(controller.adc_sensors)


def self_check_rules(controller: Controller) -> tuple[str, ...]:
    """Return the ids of the rules that the controller's self-checks can trip."""
    known = measures_known_voltage(controller)
    rules = SELF_CHECK_RULES if self_checked(controller) else ()
    return tuple(rule for rule in rules if known or rule != "adc_wrong")
