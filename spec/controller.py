"""The model of the whole spec, which never changes after loading."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field, StrictBool, model_validator

from heatwright.spec.algorithms import Algorithm
from heatwright.spec.base import (
    DEFAULTS,
    MOST_ENTRIES,
    Filled,
    Model,
    Name,
    Off,
    PinName,
    ReadOnlyDict,
    Reference,
    Temperature,
    Title,
    WholeNumber,
)
from heatwright.spec.boards import BOARDS, Board
from heatwright.spec.interfaces import Interface
from heatwright.spec.loading.suggest import one_of
from heatwright.spec.loops import Limits, Loop, shortest_period_s
from heatwright.spec.monitors import Inputs, Monitors
from heatwright.spec.outputs import DigitalOutput, Output, Stepper, Switch
from heatwright.spec.physics.derived import with_derived
from heatwright.spec.physics.stand import LONGEST_WITHIN_S
from heatwright.spec.problems import Checked, refuse
from heatwright.spec.programs import Programs
from heatwright.spec.quantity import Quantity, QuantityRange
from heatwright.spec.sensing.currents import CurrentSensor
from heatwright.spec.sensors import AdcSensor, Sensor, Thermometer
from heatwright.spec.simulation import Simulation
from heatwright.spec.units import DURATION, FREQUENCY, TEMPERATURE

FORMAT = 1
"""The version of the language; a file states it as `heatwright: 1`."""

WATCHDOG_S = (0.015, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""The AVR's watchdog periods; not every chip has the longest ones."""


def _format(value: Any) -> int:
    if isinstance(value, bool) or value != FORMAT:
        raise refuse(f"this is not version {FORMAT} of the language", f"Write heatwright: {FORMAT}")
    return FORMAT


def _board(value: Any) -> str:
    if not isinstance(value, str) or value not in BOARDS:
        raise one_of(value, "board", list(BOARDS))
    return value


class Identity(Model):
    """The controller's name, its board and its clock."""

    name: Name = Field(description="Name of the generated folder and files.")
    title: Title | None = Field(None, description="Description. Default: the name.")
    board: Annotated[str, Checked(_board, enum=list(BOARDS))] = Field(
        description="The board, or bare chip."
    )
    clock_hz: Annotated[float, Quantity(FREQUENCY, least=8e6)] | None = Field(
        None, alias="clock", description="The crystal's frequency. Default: the board's own."
    )


_LockoutTime = Annotated[float, Quantity(DURATION, least=1.0, most=LONGEST_WITHIN_S)]


class Lockout(Limits):
    """After several trips within a time, only a person at the machine can acknowledge."""

    trips: Annotated[int, WholeNumber("a number of trips", 1, 100, 3)] = Field(
        3,
        description="Number of trips after which nobody can acknowledge remotely. Default: 3, or "
        "fewer if the plant withstands no more.",
    )
    within_s: _LockoutTime = Field(
        1800.0,
        alias="within",
        description="Trips within this time are counted. Default: 30 min, or from the plant.",
    )
    hold_s: Annotated[float, Quantity(DURATION, least=3.0, most=60.0)] = Field(
        5.0, alias="hold", description="With a keypad: time for which a person holds SELECT."
    )
    wait_s: _LockoutTime = Field(
        600.0,
        alias="wait",
        description="Without a keypad: time after a loss of power until somebody may acknowledge.",
    )


class Safety(Model):
    """Protections of the controller itself, and the lock-out after repeated trips."""

    watchdog_s: Annotated[float, Quantity(DURATION, choices=WATCHDOG_S)] = Field(
        2.0, alias="watchdog", description="Time after which a hung program is reset."
    )
    relay: Reference | None = Field(
        None, description="Digital output in series with the heaters; closed only to heat."
    )
    relay_feedback: PinName | None = Field(
        None,
        description="Pin at a contact of the relay that is closed to ground while the relay is "
        "open.",
    )
    inputs: Inputs = Field(
        ReadOnlyDict({}),
        description="Contacts of door, emergency stop or thermal cut-out, by name: while one is "
        "open nothing heats.",
    )
    lockout: Annotated[Lockout | None, Off] = Field(
        DEFAULTS, validate_default=True, description="Lock-out after repeated trips, or `off`."
    )
    self_checks: StrictBool = Field(
        True, description="Whether the controller checks its own processor, memories and clock."
    )


class Published(Model):
    """Figures of a published experiment, to compare with the simulated ones."""

    maximum_c: Temperature = Field(alias="maximum", description="Highest temperature.")
    steady_c: Annotated[tuple[float, float], QuantityRange(TEMPERATURE)] = Field(
        alias="steady", description="Lowest and highest temperature of the steady part."
    )

    @property
    def steady_minimum_c(self) -> float:
        """Lowest temperature of the steady part, °C."""
        return self.steady_c[0]

    @property
    def steady_maximum_c(self) -> float:
        """Highest temperature of the steady part, °C."""
        return self.steady_c[1]


class ComparisonRow(Model):
    """One experiment of a comparison: the same machine under another algorithm."""

    name: Title = Field(description="Name of the row.")
    loop: Reference | None = Field(
        None, description="Loop that is varied; needed where there are several."
    )
    setpoint_c: Temperature = Field(alias="setpoint", description="Setpoint of the experiment.")
    algorithm: Algorithm = Field(description="Replaces the loop's algorithm.")
    output: Output | None = Field(None, description="Replaces the loop's heater.")
    published: Published | None = Field(None, description="Published figures, if there are any.")


class Controller(Model):
    """One thermal controller."""

    format: Annotated[int, Checked(_format, const=FORMAT)] = Field(
        alias="heatwright", description="Version of the language."
    )
    identity: Identity = Field(alias="controller", description="Name and board.")
    sensors: Annotated[Mapping[Name, Sensor], Filled] = Field(description="Sensors by name.")
    outputs: Annotated[Mapping[Name, Output], Filled] = Field(description="Outputs by name.")
    loops: Annotated[Mapping[Name, Loop], Filled] = Field(description="Control loops by name.")
    monitors: Monitors = Field(
        ReadOnlyDict({}), description="Sensors of no loop, by the monitor's name."
    )
    programs: Programs | None = Field(None, description="Ramp programs of one loop.")
    safety: Safety = Field(
        DEFAULTS, validate_default=True, description="Watchdog, relay and inputs."
    )
    interfaces: tuple[Interface, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Displays, keypads, LEDs, serial lines."
    )
    simulation: Simulation | None = Field(None, description="The simulated machine.")
    comparison: tuple[ComparisonRow, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Experiments for `heatwright compare`."
    )

    @model_validator(mode="after")
    def _derive(self) -> "Controller":
        return with_derived(self)

    @property
    def lockout(self) -> Lockout | None:
        """The lock-out after repeated trips; None if it is off, or nobody can acknowledge."""
        return self.safety.lockout if self.is_acknowledged else None

    @property
    def is_acknowledged(self) -> bool:
        """Whether somebody can acknowledge faults, of all loops alike."""
        return any(interface.acknowledges for interface in self.interfaces)

    @property
    def shortest_period_s(self) -> float:
        """The shortest period of the loops, s."""
        return shortest_period_s(self.loops.values())

    @property
    def longest_period_s(self) -> float:
        """The longest period of the loops, s."""
        return max(loop.period_s for loop in self.loops.values())

    def with_loop(self, name: str, loop: Loop) -> "Controller":
        """Return the controller with one loop replaced; defaults are not derived again."""
        return self.model_copy(update={"loops": ReadOnlyDict({**self.loops, name: loop})})

    @property
    def board(self) -> Board:
        """The board, at the clock this spec gives it."""
        board = BOARDS[self.identity.board]
        if self.identity.clock_hz is None:
            return board
        return replace(board, clock_hz=round(self.identity.clock_hz))

    @property
    def switches(self) -> Mapping[str, Switch]:
        """The outputs that drive a load at one pin, by name."""
        return {name: output for name, output in self.outputs.items() if not output.feeds}

    @property
    def steppers(self) -> Mapping[str, Stepper]:
        """The stepper outputs, which feed material, by name."""
        return {name: each for name, each in self.outputs.items() if each.feeds}

    @property
    def simulated(self) -> Simulation:
        """The simulated machine, where one is needed. Raises ValueError: there is none."""
        if self.simulation is None:
            raise ValueError("A machine is needed: the specification has no `simulation`")
        return self.simulation

    def on_off_output(self, name: str) -> DigitalOutput:
        """Return an output that can only be digital: a fan, a cooler or a relay.

        Raises TypeError: it is of another kind, which `check` refuses.
        """
        output = self.outputs[name]
        if not output.is_on_off:
            message = f"{name} is of the kind {output.kind}, and not digital"
            raise TypeError(message)
        return output

    @property
    def thermometers(self) -> Mapping[str, Thermometer]:
        """The sensors that measure temperatures, by name."""
        return {name: each for name, each in self.sensors.items() if not each.measures_current}

    @property
    def ammeters(self) -> Mapping[str, CurrentSensor]:
        """The sensors that measure currents, by name."""
        return {name: each for name, each in self.sensors.items() if each.measures_current}

    @property
    def adc_sensors(self) -> Mapping[str, AdcSensor]:
        """The sensors on pins of the ADC, by name."""
        return {name: each for name, each in self.sensors.items() if each.on_adc}
