"""The rules of the protections: each has one code and one id, the same wherever it appears."""

from typing import NamedTuple


class Rule(NamedTuple):
    """One reason to switch a heater off until somebody acknowledges. A code never changes."""

    code: int
    id: str
    display: str
    """At most 12 ASCII characters, which fit beside `E06 ` on a 16-column display."""
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
        "The sensor reads as if its wires were shorted.",
        "Look for a short circuit in its cable and its connectors.",
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
        "No reading has come from the sensor for too long.",
        "Check the sensor; if it works, report this: it is an error of the firmware.",
    ),
    Rule(
        5,
        "sensor_reset",
        "SENSOR RESET",
        "The sensor has lost its settings, as its supply has failed.",
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
        "Check the sensor and its wires: a reading this low is usually wrong.",
    ),
    Rule(
        8,
        "rise_rate",
        "JUMP",
        "The reading changed faster than the machine's temperature can.",
        "Check the sensor's contacts and its place.",
    ),
    Rule(
        9,
        "sensor_frozen",
        "FROZEN",
        "The reading has not changed although the heater was on.",
        "Check that the sensor sits in its place; if it does, replace it.",
    ),
    Rule(
        10,
        "heating_failed",
        "NO HEATING",
        "Full power did not raise the temperature.",
        "Check the heater, its supply and its switch, and the sensor's place.",
    ),
    Rule(
        11,
        "runaway_above",
        "RUNAWAY HIGH",
        "The temperature rose above the band around the setpoint, and stayed there.",
        "Look for a switch that conducts while it is off.",
    ),
    Rule(
        12,
        "runaway_below",
        "RUNAWAY LOW",
        "The temperature fell below the band around the setpoint, and stayed there.",
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
        "Look for disturbances on its supply; if the fault comes again, report it.",
    ),
    Rule(
        15,
        "brown_out",
        "BROWN-OUT",
        "The controller's supply voltage fell too low.",
        "Check the supply's voltage while the heater switches on.",
    ),
    Rule(
        16,
        "settings_corrupt",
        "SETTINGS BAD",
        "The stored settings cannot be read.",
        "Enter them again; if the fault comes again, replace the controller.",
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
        "The host commanded an emergency stop.",
        "Find out why; then acknowledge the fault.",
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
        "Check the heater, its wires, its fuse, its supply and the current sensor.",
    ),
    Rule(
        23,
        "master_lost",
        "MASTER LOST",
        "The master, or the host, has sent nothing to the controller for too long.",
        "Check the line and the program at its other end; then acknowledge the fault.",
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
        "The feedback contact shows the safety relay closed although it is off.",
        "Disconnect the supply and replace the relay; check its feedback contact.",
    ),
    Rule(
        26,
        "relay_open",
        "RELAY OPEN",
        "The feedback contact shows the safety relay open although it is on.",
        "Check the relay's coil, its driver and its feedback contact.",
    ),
    Rule(
        27,
        "monitor_limit",
        "MONITOR HOT",
        "A monitored part reached its limit.",
        "Let the part cool; find out what heats it, or why it is no longer cooled.",
    ),
    Rule(
        28,
        "fan_stopped",
        "FAN STOPPED",
        "The fan is on, but its airflow switch, contact or tachometer does not show that it turns.",
        "Check fan, supply and filter; then airflow switch, contact or tachometer, and its wires.",
    ),
    Rule(
        29,
        "memory_damaged",
        "MEMORY BAD",
        "A byte of memory that decides about the heater has changed by itself.",
        "Enter all settings again; if the fault comes again, replace the controller.",
    ),
    Rule(
        30,
        "on_too_long",
        "ON TOO LONG",
        "The loop has been on for as long as it may be.",
        "Check whether heat is still needed; then acknowledge the fault and switch it on again.",
    ),
    Rule(
        31,
        "input_open",
        "INPUT OPEN",
        "A contact that must be closed for heat is open: a door, an emergency stop, a cut-out.",
        "Find out which contact is open, and why; if it looks closed, look for a broken wire.",
    ),
    Rule(
        32,
        "sensors_disagree",
        "DISAGREE",
        "The loop's sensor and its second sensor read different temperatures.",
        "Check the place, the wires and the settings of both; replace the sensor that is wrong.",
    ),
    Rule(
        33,
        "effort_high",
        "MUCH POWER",
        "The loop takes more power than a healthy machine needs for this reading.",
        "Check the sensor, its place and its type; then heater, supply and walls.",
    ),
    Rule(
        34,
        "effort_low",
        "LITTLE POWER",
        "The loop takes less power than a healthy machine needs for this reading.",
        "Look for a switch that leaks; check the sensor: its reading may be too high.",
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
        "The program in the chip has changed since it was put there.",
        "Program the chip again; if the fault comes again, replace the controller.",
    ),
    Rule(
        37,
        "clock_wrong",
        "CLOCK",
        "Clock and watchdog differ too much, or the watchdog does not reset.",
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
        "The processor has skipped a part of its program.",
        "Check its supply for noise; if the fault returns, replace the controller.",
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
        "Enter all settings again; if the fault comes again, report it.",
    ),
    Rule(
        42,
        "flash_unsealed",
        "NOT SEALED",
        "The program was put into the chip without its checksum.",
        "Build it with PlatformIO, or seal it with its project's seal.py; then upload it.",
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
"""Rules whose trips do not count for a lock-out: the controller, its supply, host or operator
causes them, not the machine, its heater or its sensors."""

RULES: dict[int, Rule] = {rule.code: rule for rule in _RULES}
"""All rules by code, in the order of their codes."""
