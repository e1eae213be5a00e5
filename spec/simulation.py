"""The simulated machine: a plant, a scenario of events, and limits that `verify` checks."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from heatwright.spec.base import (
    MOST_ENTRIES,
    Filled,
    Model,
    Name,
    ReadOnly,
    Reference,
    Temperature,
    WholeNumber,
)
from heatwright.spec.physics.sizing import Sizing
from heatwright.spec.problems import Checked, refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.registry import with_brought
from heatwright.spec.scenario.program_orders import ProgramOrders
from heatwright.spec.scenario.writes import Writes
from heatwright.spec.units import (
    AREA,
    CAPACITY,
    DIFFERENCE,
    DURATION,
    FEED_HEAT,
    PERCENT,
    SPEED,
    THERMAL_RESISTANCE,
)

LONGEST_LINE = 500
"""Maximum length of a line that is sent: a display's whole program of 20 segments."""

AMBIENT = "ambient"
"""The node whose temperature never changes."""

_Time = Annotated[float, Quantity(DURATION, least=0.0)]
_Difference = Annotated[float, Quantity(DIFFERENCE, least=0.0)]


def _factor(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value <= 1000:
        raise refuse("a factor is a bare number above 0, up to 1000", "Write, for example, 1.4")
    return float(value)


class Link(Model):
    """A thermal resistance between two nodes, or a node and `ambient`."""

    between: tuple[Reference, Reference] = Field(description="The two nodes.")
    resistance_k_per_w: Annotated[float, Quantity(THERMAL_RESISTANCE, least=1e-6)] = Field(
        alias="resistance", description="Temperature difference per watt of heat flow."
    )


def _emissivity(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.001 <= value <= 1:
        raise refuse("an emissivity is a bare number from 0.001 to 1", "Write, for example, 0.9")
    return float(value)


class Radiation(Model):
    """Heat between two nodes, or a node and `ambient`, by Stefan and Boltzmann's law."""

    between: tuple[Reference, Reference] = Field(description="The two nodes.")
    area_m2: Annotated[float, Quantity(AREA, least=1e-9)] = Field(
        alias="area", description="Surface that radiates."
    )
    emissivity: Annotated[float, Checked(_emissivity, type="number", minimum=0.001, maximum=1)] = (
        Field(description="Share of what a black body would radiate.")
    )


class Sense(Model):
    """Where a sensor sits and how it lags."""

    node: Reference | None = Field(None, description="Node whose temperature the sensor measures.")
    of: Reference | None = Field(
        None, description="Heating output whose mean current it measures, instead of a node."
    )
    lag_s: _Time = Field(0.0, alias="lag", description="Time constant of the sensor.")
    delay_s: _Time = Field(0.0, alias="delay", description="Dead time before the lag.")
    noise_k: _Difference = Field(
        0.0, alias="noise", description="Standard deviation of Gaussian noise, seeded."
    )

    @model_validator(mode="after")
    def _one_place(self) -> "Sense":
        if (self.node is None) == (self.of is None):
            raise refuse(
                "a sensor measures either a node or the current of an output",
                "Write node: … or of: …",
            )
        if self.of is not None and (self.delay_s or self.noise_k):
            raise refuse("a current has neither delay nor noise", "Delete these keys")
        return self


class FanEffect(Model):
    """How a running fan changes a link."""

    link: tuple[Reference, Reference] = Field(description="The two ends of the link.")
    factor: Annotated[float, Checked(_factor, type="number", exclusiveMinimum=0, maximum=1000)] = (
        Field(description="Factor on the link's conductance while the fan runs.")
    )


class Filament(Model):
    """Cold material that is fed through a node and takes heat along."""

    node: Reference = Field(description="Node that heats it from ambient to its own temperature.")
    heat_j_per_k_mm: Annotated[float, Quantity(FEED_HEAT, least=0.0)] = Field(
        alias="heat", description="Heat per kelvin and millimetre: area · density · specific heat."
    )


class ThermalNetwork(Model):
    """Heat capacities joined by thermal resistances."""

    kind: Literal["thermal_network"]
    nodes: Annotated[Mapping[Name, Annotated[float, Quantity(CAPACITY, least=0.001)]], Filled] = (
        Field(description="Heat capacity of each node.")
    )
    links: tuple[Link, ...] = Field(
        max_length=MOST_ENTRIES, description="Thermal resistances between nodes."
    )
    heat: Annotated[Mapping[str, Reference], Filled] = Field(
        description="For each heating output, the node its power goes to."
    )
    sense: Annotated[Mapping[str, Sense], Filled] = Field(
        description="For each sensor, where it measures."
    )
    initial_c: Temperature | None = Field(
        None, alias="initial", description="Temperature of all nodes at the start, or ambient."
    )
    bears_c: Annotated[Mapping[str, Temperature], ReadOnly] = Field(
        {},
        alias="bears",
        description="Highest temperature that each node withstands. Default: the one at which full "
        "power trips the loop's maximum, plus a tenth of the rise.",
        validate_default=True,
    )
    fans: Annotated[Mapping[str, FanEffect], ReadOnly] = Field(
        {}, description="For each fan, the link it changes.", validate_default=True
    )
    filament: Filament | None = Field(None, description="What the feed takes heat from.")
    radiation: tuple[Radiation, ...] = Field(
        (), max_length=MOST_ENTRIES, description="Surfaces that radiate to each other."
    )
    tolerance_percent: Annotated[float, Quantity(PERCENT, least=0.0, most=50.0)] = Field(
        30.0,
        alias="tolerance",
        description="Tolerance of a machine's capacities and resistances, ±.",
    )


Plant = Annotated[ThermalNetwork, Field(discriminator="kind")]
if not TYPE_CHECKING:  # mypy knows only heatwright's own kinds
    Plant = with_brought("plant", Plant)


def _line(value: Any) -> str:
    plain = isinstance(value, str) and value.isascii() and value.isprintable()
    if not plain or not value.strip() or len(value) > LONGEST_LINE:
        raise refuse(
            f"a line to send has 1 to {LONGEST_LINE} plain characters",
            "Write, for example, M104 S200",
        )
    return str(value)


_Line = Annotated[
    str,
    Checked(
        _line, type="string", minLength=1, maxLength=LONGEST_LINE, pattern="^[ -~]*[!-~][ -~]*$"
    ),
]


LEAST_VERIFIED_S = 1800.0
"""`verify` extends a shorter scenario to this length: overflow and drift of counters show late."""


class Event(Model):
    """One line of a scenario: `at` and what happens then, or `for`, which ends it."""

    at_s: _Time | None = Field(None, alias="at", description="Time since the start.")
    press: Literal["right", "up", "down", "left", "select"] | None = Field(
        None, description="Key that is pressed and released."
    )
    times: Annotated[int, WholeNumber("a number of presses", 1, 1000, 3)] = Field(
        1, description="How often the key is pressed."
    )
    held_s: Annotated[float, Quantity(DURATION, least=0.1, most=60.0)] | None = Field(
        None, alias="held", description="How long the key is down each time. Default: 0.1 s."
    )
    send: _Line | None = Field(None, description="Line that a host or a display sends.")
    extrude_mm_per_s: Annotated[float, Quantity(SPEED, least=0.0)] | None = Field(
        None, alias="extrude", description="Speed at which filament is fed from then on."
    )
    write: Writes | None = Field(
        None, description="What the master writes, such as {nozzle.setpoint: 300 °C}."
    )
    program: ProgramOrders | None = Field(
        None, description="Command to a program: `start 1`, `pause`, `jump 3` and so on."
    )
    for_s: Annotated[float, Quantity(DURATION, least=0.01)] | None = Field(
        None, alias="for", description="Length of the scenario, in its last event."
    )

    @model_validator(mode="after")
    def _one_thing(self) -> "Event":
        if self.for_s is not None:
            if self.at_s is not None or self._actions or self._pressing:
                raise refuse(
                    "`for` ends the scenario and is an event of its own", "Write it as a new item"
                )
        elif self.at_s is None or self._actions != 1:
            raise refuse(
                "an event needs a time and one action",
                "Write {at: 10 s, press: up} or {for: 30 min}",
            )
        elif self.press is None and self._pressing:
            raise refuse(
                "only a key can be pressed several times, or held", f"Delete {self._pressing}"
            )
        return self

    @property
    def _pressing(self) -> str:
        """Name the key of the event that says how to press, `held` or `times`; "" without one."""
        if self.held_s is not None:
            return "held"
        return "times" if self.times != 1 else ""

    @property
    def _actions(self) -> int:
        actions = (self.press, self.send, self.extrude_mm_per_s, self.write, self.program)
        return sum(action is not None for action in actions)


class Expect(Model):
    """Limits of the closed loop that `verify` checks."""

    overshoot_k: _Difference | None = Field(
        None, alias="overshoot", description="Largest overshoot above the setpoint."
    )
    steady_k: _Difference | None = Field(
        None, alias="steady", description="Largest deviation in the steady part, both ways."
    )
    tracking_k: _Difference | None = Field(
        None,
        alias="tracking",
        description="Largest deviation on a program's ramps, after the first minute of each, "
        "while the heater can follow.",
    )


class Simulation(Model):
    """The world around the controller; it does not change the firmware."""

    ambient_c: Temperature = Field(alias="ambient", description="Temperature around the machine.")
    plant: Plant = Field(description="The machine.")
    scenario: tuple[Event, ...] = Field(
        max_length=MOST_ENTRIES, description="What happens, in the order of time."
    )
    expect: Expect | None = Field(None, description="Limits that `verify` checks.")
    sizing: Annotated[Mapping[str, Sizing], ReadOnly] = Field(
        {},
        description="For each loop, walls and wire by which its heater is sized.",
        validate_default=True,
    )
