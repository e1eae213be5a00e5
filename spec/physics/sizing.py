"""Data for sizing a machine's heater: the walls, and the heater's wire."""

from typing import Annotated

from pydantic import Field, model_validator

from heatwright.spec.base import MOST_ENTRIES, BareNumber, Model, Temperature
from heatwright.spec.problems import refuse
from heatwright.spec.quantity import Quantity
from heatwright.spec.units import (
    AIR_SPEED,
    AREA,
    CONDUCTIVITY,
    FILM,
    LENGTH,
    RESISTIVITY,
    SURFACE_LOAD,
    VOLTAGE,
)

_Film = Annotated[float, Quantity(FILM, least=0.001)]
_Emissivity = Annotated[float, BareNumber(0.0, 1.0, "0.9", closed=True)]


class Layer(Model):
    """One material of a wall."""

    thickness_mm: Annotated[float, Quantity(LENGTH, least=0.001)] = Field(
        alias="thickness", description="Thickness of the layer."
    )
    conductivity_w_per_mk: Annotated[float, Quantity(CONDUCTIVITY, least=1e-4)] = Field(
        alias="conductivity", description="Thermal conductivity of the material."
    )


class Wall(Model):
    """A wall between the heated space and the surroundings."""

    area_m2: Annotated[float, Quantity(AREA, least=1e-9)] = Field(
        alias="area", description="Surface of one side."
    )
    layers: tuple[Layer, ...] = Field(
        max_length=MOST_ENTRIES, description="The wall's layers, from side to side."
    )
    inside_w_per_m2k: _Film = Field(
        8.7, alias="inside", description="Heat transfer from the air inside to the wall."
    )
    outside_w_per_m2k: _Film | None = Field(
        None, alias="outside", description="The same, outside. Default: from `wind`, or 8.7 W/m²K."
    )
    wind_m_per_s: Annotated[float, Quantity(AIR_SPEED, least=0.0, most=30.0)] | None = Field(
        None, alias="wind", description="Speed of the air along the wall, instead of `outside`."
    )
    emissivity: _Emissivity = Field(
        0.0, description="Share of what a black body would radiate, outside."
    )

    @model_validator(mode="after")
    def _whole(self) -> "Wall":
        if not self.layers:
            raise refuse("a wall has at least one layer", "List its layers")
        if self.outside_w_per_m2k is not None and self.wind_m_per_s is not None:
            raise refuse("outside and wind give the same value", "Delete one of them")
        return self


class Wire(Model):
    """The resistance wire of a heater, in moving air."""

    resistivity_ohm_mm2_per_m: Annotated[float, Quantity(RESISTIVITY, least=1e-3)] = Field(
        alias="resistivity", description="Resistivity of the hot alloy."
    )
    surface_load_w_per_cm2: Annotated[float, Quantity(SURFACE_LOAD, least=0.001)] = Field(
        alias="surface_load", description="Heat that the wire's surface gives off at full power."
    )
    voltage_v: Annotated[float, Quantity(VOLTAGE, least=0.001)] | None = Field(
        None,
        alias="voltage",
        description="Voltage at which the wire has the heater's power. Default: the heater's "
        "`rated`, or its `supply`.",
    )
    air_speed_m_per_s: Annotated[float, Quantity(AIR_SPEED, least=0.1, most=100.0)] = Field(
        alias="air_speed", description="Speed of the air across the wire."
    )
    air_c: Temperature | None = Field(
        None, alias="air", description="Temperature of the air. Default: the highest setpoint."
    )
    emissivity: _Emissivity = Field(0.0, description="Share of what a black body would radiate.")
    measured_c: Temperature | None = Field(
        None, alias="measured", description="Measured temperature of the wire, for comparison."
    )


class Sizing(Model):
    """Data by which the power of one loop's heater is chosen."""

    walls: tuple[Wall, ...] = Field(
        (), max_length=MOST_ENTRIES, description="All walls through which heat is lost."
    )
    wire: Wire | None = Field(None, description="The heater's wire.")
