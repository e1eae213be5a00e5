"""Temperatures that are kept in tenths of a degree: in a master's registers, and in programs."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import modbus_of, programmed
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import number

LARGEST = 32767
"""Maximum number of tenths in 16 bits; -32768 means that there is no temperature."""

_REGISTER = ("a register", "the master writes this value")
_PROGRAM = ("a program", "programs set this setpoint")


def setpoints_fit_tenths(controller: Controller) -> Findings:
    """Check that setpoints fit a register or a program: tenths of a degree, in 16 bits."""
    for name, loop in controller.loops.items():
        by_master = modbus_of(controller) is not None
        if not by_master and not programmed(controller, name):
            continue
        setpoint = loop.setpoint
        by = _REGISTER if by_master else _PROGRAM
        for key, value_c in (
            ("initial", setpoint.initial_c),
            ("minimum", setpoint.minimum_c),
            ("maximum", setpoint.maximum_c),
        ):
            yield from fits(("loops", name, "setpoint", key), value_c, "°C", by)


def fits(path: Path, value: float, unit: str, by: tuple[str, str] = _REGISTER) -> Findings:
    """Find a value that 16 bits cannot hold in tenths."""
    limit = LARGEST / 10
    what, why = by
    because_of: tuple[Path, ...] = (("interfaces",), ("programs",))
    if abs(value) > limit:
        yield Finding(
            path,
            f"{what} holds {number(limit)} {unit} at most, and {why}",
            f"Use at most {number(limit)} {unit}",
            because_of,
        )
    elif round(value, 1) != value:
        yield Finding(
            path,
            f"{number(value)} {unit} is no multiple of 0.1 {unit}, the step of {what}, and {why}",
            f"Use {number(round(value, 1))} {unit}",
            because_of,
        )
