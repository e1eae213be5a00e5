"""The memory of logs: where their entries are, and how many bytes each takes."""

from heatwright.spec.commands import log_of, placed, programmed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import SerialLog


def log_in_eeprom(controller: Controller) -> SerialLog | None:
    """Find the log that is kept in the EEPROM, if there is one."""
    log = log_of(controller)
    return log if log is not None and log.keep == "eeprom" else None


def logs_in_ram(controller: Controller) -> dict[int, SerialLog]:
    """Find the logs that are kept in RAM, by their indices."""
    return {n: each for n, each in placed(controller, SerialLog).items() if each.keep == "ram"}


def log_entry_bytes(controller: Controller, log: SerialLog) -> int:
    """Count the bytes of an entry: temperature, setpoint, duty; one for program and segment."""
    return 2 + 2 + 1 + programmed(controller, log.loop)
