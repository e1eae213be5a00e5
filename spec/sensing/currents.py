"""The current of a heater: how it is measured, limited and watched."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from heatwright.spec.base import DEFAULTS, Least, Model, PinName, Reference, WholeNumber
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.sensing.analog_parts import FullScale, Volt
from heatwright.spec.sensing.circuits import Linear, of_voltage, reference_v
from heatwright.spec.sensing.tolerances import VoltageTolerances
from heatwright.spec.units import CURRENT, VOLTAGE_PER_AMPERE

TRIP_FACTOR = 1.25
"""Default of `trip`, as a multiple of `limit`: the limiter settles within a few percent, and a wire
that heats up changes its resistance by less."""

FILTER_PULSES = 5
"""Least time constant of the filter that averages the PWM, in periods of the PWM."""

LIMITED_PARTS = 3
"""With a limit, the filter's time constant is at most the period divided by this: a slower filter
would still show the current of the previous duty."""

_Ampere = Annotated[float, Quantity(CURRENT, least=0.001)]


class CurrentSensor(Model):
    """Current of a heater as a voltage on a pin of the ADC: a shunt's amplifier, a Hall sensor."""

    kind: Literal["current"]
    pin: PinName = Field(description="A pin that leads to the ADC.")
    scale_v_per_a: Annotated[float, Quantity(VOLTAGE_PER_AMPERE, least=0.0001)] = Field(
        alias="scale", description="Voltage per ampere."
    )
    offset_v: Volt = Field(0.0, alias="offset", description="Voltage at 0 A.")
    oversample: Annotated[int, WholeNumber("a number of readings", 1, 32, 4)] = Field(
        4, description="Number of readings, one every 10 ms, that are summed up to one."
    )
    reference: FullScale = Field(
        "supply", description="Full scale of the ADC: `supply`, `internal`, or the volts at AREF."
    )
    tolerances: VoltageTolerances = Field(
        DEFAULTS, validate_default=True, description="Tolerances of sensor and reference."
    )
    least: ClassVar[Least] = Least(210, 4)
    on_adc: ClassVar[Literal[True]] = True
    on_one_wire: ClassVar[bool] = False
    measures_current: ClassVar[Literal[True]] = True
    rules: ClassVar[tuple[int, ...]] = (4, 20, 21, 22)
    unit: ClassVar[str] = "A"

    def shown_range(self, mcu: str) -> tuple[float, float]:
        """Currents that the ADC of a chip can show, A."""
        return 0.0, (reference_v(self, mcu) - self.offset_v) / self.scale_v_per_a

    def circuit(self, mcu: str) -> Linear:
        """Return the circuit between its current and the ADC of a chip."""
        return of_voltage(self, self.scale_v_per_a, mcu, open_is_high=False)


class Current(Model):
    """A heater's current is measured, limited by its duty, and watched."""

    sensor: Reference = Field(description="Sensor of the kind `current` in the heater's wire.")
    limit_a: _Ampere | None = Field(
        None, alias="limit", description="Root mean square that a reduced duty keeps; `pwm` only."
    )
    trip_a: _Ampere | None = Field(
        None,
        alias="trip",
        description="Rule `over_current`: root mean square that trips. Default: 1.25 of the limit.",
    )

    @model_validator(mode="after")
    def _something_to_hold(self) -> Current:
        if self.limit_a is None and self.trip_a is None:
            raise refuse(
                "a measured current needs a limit or a trip",
                "Write limit or trip, such as {sensor: current, limit: 3 A}",
            )
        return self

    @property
    def over_a(self) -> float:
        """Current that trips `over_current`, A; like the limit, a root mean square at full duty."""
        if self.trip_a is not None:
            return self.trip_a
        return TRIP_FACTOR * (self.limit_a or 0.0)

    @property
    def nominal_a(self) -> float:
        """Largest healthy current, A, as a root mean square: the limit, if there is one."""
        return self.over_a / TRIP_FACTOR if self.limit_a is None else self.limit_a

    @property
    def filter_parts(self) -> int:
        """Divisor of the control period; the result is the filter's longest time constant."""
        return 1 if self.limit_a is None else LIMITED_PARTS
