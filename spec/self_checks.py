"""Self-checks of the controller, as IEC 60730 class B requires them."""

from heatwright.spec.controller import Controller

FLASH_BYTES_A_TICK = 2
"""Bytes of the flash that each tick of 10 ms adds to its CRC."""

SELF_CHECK_RULES = (
    "ram_damaged", "flash_damaged", "clock_wrong", "eeprom_worn", "sequence_broken", "adc_wrong",
    "stack_overrun", "flash_unsealed", "pin_held",
)  # fmt: skip
"""Ids of the self-checks' rules. `adc_wrong` needs a sensor on the ADC, `clock_wrong` a watchdog
that can be tested."""


def proves_watchdog(controller: Controller) -> bool:
    """Return whether the start tests the watchdog by a reset; some bootloaders do not allow it."""
    return controller.safety.self_checks and controller.board.bears_watchdog


def measures_known_voltage(controller: Controller) -> bool:
    """Return whether the ADC also measures a known voltage."""
    return controller.safety.self_checks and bool(controller.adc_sensors)


def read_back(controller: Controller) -> tuple[str, ...]:
    """Name the outputs whose pins are read back, except while they pulse: relay and heaters."""
    if not controller.safety.self_checks:
        return ()
    carry_heat = {controller.safety.relay, *(loop.heater for loop in controller.loops.values())}
    return tuple(name for name in controller.switches if name in carry_heat)


def self_check_rules(controller: Controller) -> tuple[str, ...]:
    """Return the ids of the rules that the controller's self-checks can trip."""
    if not controller.safety.self_checks:
        return ()
    found = {"adc_wrong": measures_known_voltage, "clock_wrong": proves_watchdog}
    return tuple(rule for rule in SELF_CHECK_RULES if rule not in found or found[rule](controller))
