"""The rules of the protections: each has one code and one id, the same wherever it appears."""

from typing import NamedTuple


class Rule(NamedTuple):
    """One reason to switch a heater off for good. Codes are never renumbered."""

    code: int
    id: str
    display: str
    """At most 12 ASCII characters: what fits beside `E06 ` on a 16-column display."""
    meaning: str
    remedy: str


_RULES = (
    Rule(
        1,
        "sensor_no_answer",
        "NO SENSOR",
        "The sensor does not answer.",
        "Check its cable, its supply and its pull-up resistor.",
    ),
    Rule(
        2,
        "sensor_short",
        "SENSOR SHORT",
        "The sensor's line is held at one end, as by a short circuit.",
        "Look for a short circuit in its cable.",
    ),
    Rule(
        3,
        "sensor_crc",
        "SENSOR CRC",
        "The sensor's answers arrive damaged.",
        "Shorten or shield its cable; keep it away from the heater's wires.",
    ),
    Rule(
        4,
        "sensor_stale",
        "SENSOR STALE",
        "No reading has come for too long.",
        "Check the sensor; then report this, for the firmware should have had one.",
    ),
    Rule(
        5,
        "sensor_reset",
        "SENSOR RESET",
        "The sensor has lost its settings: its supply broke down.",
        "Check the sensor's supply and its capacitor.",
    ),
    Rule(
        6,
        "over_temperature",
        "TOO HOT",
        "The temperature reached the protection's maximum.",
        "Find out what heats: a shorted switch, a wrong setting, a fan that stands still.",
    ),
    Rule(
        7,
        "under_temperature",
        "TOO COLD",
        "The temperature fell to the protection's minimum.",
        "Check the sensor: so low a reading is mostly a damaged one.",
    ),
    Rule(
        8,
        "rise_rate",
        "JUMP",
        "The temperature changed faster than the machine can.",
        "Check the sensor's contacts and where it sits.",
    ),
    Rule(
        9,
        "sensor_frozen",
        "FROZEN",
        "The reading has not moved although the heater was on.",
        "Replace the sensor; check that it sits where it measures.",
    ),
    Rule(
        10,
        "heating_failed",
        "NO HEATING",
        "Full power did not raise the temperature.",
        "Check the heater, its supply and its switch, and where the sensor sits.",
    ),
    Rule(
        11,
        "runaway_above",
        "RUNAWAY HIGH",
        "The temperature left the band about the setpoint upwards, and stayed there.",
        "Look for a switch that conducts while it is off.",
    ),
    Rule(
        12,
        "runaway_below",
        "RUNAWAY LOW",
        "The temperature left the band about the setpoint downwards, and stayed there.",
        "Check the heater and the sensor; look for a draught or an open door.",
    ),
    Rule(
        13,
        "rising_while_off",
        "HEATS IN OFF",
        "The temperature rises although the heater is off.",
        "Disconnect the supply: the switch conducts while it is off.",
    ),
    Rule(
        14,
        "watchdog_reset",
        "WATCHDOG",
        "The watchdog had to reset the controller.",
        "Look for disturbances on its supply; if it comes again, report it.",
    ),
    Rule(
        15,
        "brown_out",
        "BROWN-OUT",
        "The controller's supply broke down.",
        "Check the supply's voltage while the heater switches on.",
    ),
    Rule(
        16,
        "settings_corrupt",
        "SETTINGS BAD",
        "The stored settings cannot be read.",
        "Set them again; if it comes again, replace the controller.",
    ),
    Rule(
        17,
        "sensor_open",
        "SENSOR OPEN",
        "The sensor reads as if its wire were broken.",
        "Check its cable and its connectors.",
    ),
    Rule(
        18,
        "sensor_range",
        "OUT OF RANGE",
        "The sensor reads a temperature outside its range.",
        "Check the sensor and its resistors; widen its range if the temperature is real.",
    ),
    Rule(
        19,
        "emergency_stop",
        "STOPPED",
        "The host ordered an emergency stop.",
        "Find out why; then acknowledge it.",
    ),
    Rule(
        20,
        "over_current",
        "OVER CURRENT",
        "The heater takes more current than it may.",
        "Look for a short circuit in the heater and its wires.",
    ),
    Rule(
        21,
        "current_while_off",
        "LEAKS IN OFF",
        "Current flows through the heater although it is off.",
        "Disconnect the supply: the switch conducts while it is off.",
    ),
    Rule(
        22,
        "no_current",
        "NO CURRENT",
        "The heater is on, and too little current flows.",
        "Check the heater, its wires, its fuse, its supply and the current's sensor.",
    ),
    Rule(
        23,
        "master_lost",
        "MASTER LOST",
        "The master, or the host, has not asked anything for too long.",
        "Check the line and the program at its other end; then acknowledge it.",
    ),
    Rule(
        24,
        "program_lags",
        "KILN LAGS",
        "The machine has lagged behind its program for too long.",
        "Check the heater and its supply; then give the program slower ramps.",
    ),
    Rule(
        25,
        "relay_welded",
        "RELAY WELDED",
        "The safety relay's contact says closed although the relay is off.",
        "Disconnect the supply and replace the relay; check its feedback contact.",
    ),
    Rule(
        26,
        "relay_open",
        "RELAY OPEN",
        "The safety relay's contact says open although the relay is on.",
        "Check the relay's coil, its driver and its feedback contact.",
    ),
    Rule(
        27,
        "monitor_limit",
        "MONITOR HOT",
        "A monitored part reached its limit.",
        "Let it cool; find out what heats it, or no longer cools it.",
    ),
    Rule(
        28,
        "fan_stopped",
        "FAN STOPPED",
        "Nothing proves that the fan turns although it is on.",
        "Check the fan, its supply and its filter, then what proves it, and its wires.",
    ),
    Rule(
        29,
        "memory_damaged",
        "MEMORY BAD",
        "A byte of memory that decides about the heater has changed by itself.",
        "Enter all settings again; if it comes again, replace the controller.",
    ),
    Rule(
        30,
        "on_too_long",
        "ON TOO LONG",
        "The loop has been on for as long as it may be.",
        "See whether it is still needed; then acknowledge it, and switch it on again.",
    ),
    Rule(
        31,
        "input_open",
        "INPUT OPEN",
        "A contact that has to be closed for heat is open: a door, an emergency stop, a cut-out.",
        "Find out which it is, and why; look for a torn wire where it seems closed.",
    ),
    Rule(
        32,
        "sensors_disagree",
        "DISAGREE",
        "The loop's sensor and the second one say different temperatures.",
        "Check where both sit, their wires and their settings; replace the one that is wrong.",
    ),
    Rule(
        33,
        "effort_high",
        "MUCH POWER",
        "It takes more power than a machine of this kind ever needs for its reading.",
        "Check the sensor, its place and its kind; then heater, supply and walls.",
    ),
    Rule(
        34,
        "effort_low",
        "LITTLE POWER",
        "It takes less power than a machine of this kind needs for its reading.",
        "Look for a switch that leaks; check the sensor: the reading stands too high.",
    ),
    Rule(
        35,
        "ram_damaged",
        "RAM",
        "A cell of the chip's RAM does not keep what is written to it.",
        "Replace the controller.",
    ),
    Rule(
        36,
        "flash_damaged",
        "FLASH",
        "The program in the chip is no longer the one that was put there.",
        "Program the chip again; if it comes again, replace the controller.",
    ),
    Rule(
        37,
        "clock_wrong",
        "CLOCK",
        "Clock and watchdog do not agree, or the watchdog does not reset.",
        "Check the crystal and the spec's clock; then replace the controller.",
    ),
    Rule(
        38,
        "eeprom_worn",
        "EEPROM",
        "A cell of the chip's EEPROM does not keep what was written to it.",
        "Replace the controller.",
    ),
    Rule(
        39,
        "sequence_broken",
        "SEQUENCE",
        "The processor has left out a part of its work.",
        "Look for disturbances on its supply; if it comes again, replace the controller.",
    ),
    Rule(
        40,
        "adc_wrong",
        "ADC",
        "The ADC measures a known voltage wrongly.",
        "Check its reference and the supply; then replace the controller.",
    ),
    Rule(
        41,
        "stack_overrun",
        "STACK",
        "The program's stack has grown into its variables.",
        "Enter all settings again; if it comes again, report it.",
    ),
    Rule(
        42,
        "flash_unsealed",
        "NOT SEALED",
        "The program was put into the chip without its checksum.",
        "Build it with PlatformIO, or seal it by its project's seal.py; then upload it.",
    ),
    Rule(
        43,
        "pin_held",
        "PIN HELD",
        "A heater's or the relay's pin is not at the level that was written to it.",
        "Look for a short circuit at the pin; without one replace the controller.",
    ),
)

NO_LOCKOUT = (
    "watchdog_reset", "brown_out", "settings_corrupt", "emergency_stop", "master_lost",
    "on_too_long",
)  # fmt: skip
"""Rules whose trips do not count for a lock-out: their cause is the controller, its supply, host or
operator, not the machine, its heater or its sensors."""

RULES: dict[int, Rule] = {rule.code: rule for rule in _RULES}
"""All rules by code, in the order of their codes."""
