"""The tolerances of an analog chain's parts, as their maker or the data sheet gives them."""

from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from heatwright.spec.base import ABSOLUTE_ZERO_C, BareNumber, Model
from heatwright.spec.quantity import Quantity, QuantityRange
from heatwright.spec.units import DIFFERENCE, PERCENT, TEMPERATURE, VOLTAGE

USUAL_ADC_STEPS = 2.0
"""Absolute accuracy of the chips' ADC, ± steps, including the quantization error (data sheets,
"ADC characteristics", typical, at an ADC clock of at most 200 kHz)."""

Share = Annotated[float, Quantity(PERCENT, least=0.0, most=50.0)]
_Volts = Annotated[float, Quantity(VOLTAGE, least=0.0, most=5.0)]
_SupplyVolts = Annotated[
    float | Literal["reference"], Quantity(VOLTAGE, least=0.0, most=5.0, words=("reference",))
]


class _Tolerances(Model):
    """Tolerances of all chains on the ADC."""

    reference_v: _Volts | None = Field(
        None, alias="reference", description="Tolerance, ±, of the ADC's full scale."
    )
    adc_steps: Annotated[float, BareNumber(0.0, 32.0, "2", closed=True)] = Field(
        USUAL_ADC_STEPS, alias="adc", description="Error, ±, of the ADC itself, in its steps."
    )

    @model_serializer(mode="wrap")
    def _empty_without_keys(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Dump no keys if no key is used, so that the spec's digest leaves `tolerances` out."""
        return dump(self) if self.model_fields_set else {}


class _CircuitTolerances(_Tolerances):
    """Tolerances of circuits of resistors."""

    resistors_percent: Share | None = Field(
        None, alias="resistors", description="Tolerance, ±, of each resistor of the circuit."
    )
    supply_v: _SupplyVolts | None = Field(
        None,
        alias="supply",
        description="± of the circuit's feed; `reference`: the ADC's reference feeds it.",
    )


class ThermistorTolerances(_CircuitTolerances):
    """Tolerances of a thermistor in its divider."""

    element_percent: Share | None = Field(
        None, alias="element", description="Tolerance, ±, of the thermistor's resistance."
    )
    beta_percent: Share | None = Field(
        None, alias="beta", description="Tolerance, ±, of beta; only for a curve by beta."
    )


class RtdTolerances(_CircuitTolerances):
    """Tolerances of a platinum element in its circuit."""

    element_class: Literal["AA", "A", "B", "C"] | None = Field(
        None, alias="element", description="Class of the element according to IEC 60751."
    )


class VoltageTolerances(_Tolerances):
    """Tolerances of a sensor that gives a voltage."""

    scale_percent: Share | None = Field(None, alias="scale", description="± of the scale.")
    offset_v: _Volts | None = Field(None, alias="offset", description="± of the offset.")


class Accuracy(Model):
    """The accuracy that is required of a chain."""

    within_k: Annotated[float, Quantity(DIFFERENCE, least=0.001)] = Field(
        alias="within", description="Largest allowed error, ±."
    )
    between_c: (
        Annotated[tuple[float, float], QuantityRange(TEMPERATURE, least=ABSOLUTE_ZERO_C)] | None
    ) = Field(None, alias="between", description="At these temperatures. Default: the range.")
