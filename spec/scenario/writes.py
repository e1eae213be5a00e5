"""Values that a master writes in a scenario: `{nozzle.setpoint: 300 °C, nozzle.enabled: true}`."""

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

from heatwright.spec.algorithms import Gain
from heatwright.spec.loading.suggest import advice
from heatwright.spec.problems import Checked, refuse, shown
from heatwright.spec.quantity import parse
from heatwright.spec.units import PERCENT, TEMPERATURE

SWITCHES = ("enabled", "manual", "tune")
"""Switches of a loop; each is on or off."""
GAINS = {"kp": "%/K", "ki": "%/(K·s)", "kd": "%·s/K"}
AMOUNTS = {"setpoint": TEMPERATURE, "manual_duty": PERCENT}
COMMANDS = ("acknowledge", "store", "restore")
"""Commands to the controller; only the value true has an effect."""


class Write(NamedTuple):
    """One value the master writes."""

    name: str
    """`LOOP.setpoint` and so on, or a command."""
    value: float | bool
    """The value in °C, in % or in the gain's unit; or a switch's state."""

    @property
    def loop(self) -> str:
        """The loop's name; empty for a command of the controller."""
        return self.name.rpartition(".")[0]

    @property
    def what(self) -> str:
        """Name of the value without its loop, such as `setpoint`, or of the command."""
        return self.name.rpartition(".")[2]


def _value(name: str, value: Any) -> float | bool:
    loop, _, what = name.rpartition(".")
    known = (*AMOUNTS, *GAINS, *SWITCHES) if loop else COMMANDS
    if what not in known:
        raise refuse(f"a master cannot write {shown(name)}", advice(what, known))
    if what in AMOUNTS:
        return parse(value, AMOUNTS[what])
    if what in GAINS:
        return Gain(GAINS[what]).read_gain(value)
    if not isinstance(value, bool) or (not loop and not value):
        raise refuse(
            f"{shown(value) if isinstance(value, str) else value} is no state for {name}",
            "Write true or false" if loop else "Write true",
        )
    return value


def _writes(value: Any) -> Any:
    if isinstance(value, tuple) and value and all(isinstance(each, Write) for each in value):
        return value  # already converted
    if not isinstance(value, Mapping) or not value:
        raise refuse(
            "names with values are needed here", "Write them, as {nozzle.setpoint: 300 °C}"
        )
    return tuple(Write(str(name), _value(str(name), each)) for name, each in value.items())


Writes = Annotated[
    tuple[Write, ...],
    Checked(
        _writes,
        type="object",
        minProperties=1,
        patternProperties={
            rf"^[a-z0-9_]+\.({'|'.join(AMOUNTS)})$": {"type": "string"},
            rf"^[a-z0-9_]+\.({'|'.join(GAINS)})$": {"type": "number", "minimum": 0},
            rf"^[a-z0-9_]+\.({'|'.join(SWITCHES)})$": {"type": "boolean"},
            f"^({'|'.join(COMMANDS)})$": {"const": True},
        },
        additionalProperties=False,
    ),
]
