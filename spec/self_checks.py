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
    "stack_overrun",
    "flash_unsealed",
)
"""Ids of the rules that come with the self-checks."""


def self_checked(controller: Controller) -> bool:
    """Tell whether the controller checks itself."""
    return controller.safety.self_checks
