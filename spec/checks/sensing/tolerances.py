"""Tolerances of analog chains: each belongs to a part; a voltage has a tolerance up to its half."""

from collections.abc import Iterator
from typing import Any

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.quantity import celsius, number
from heatwright.spec.sensing.analog_parts import BetaCurve
from heatwright.spec.sensing.budget import fed_v, hangs_on_supply
from heatwright.spec.sensing.circuits import reference_v
from heatwright.spec.sensing.tolerances import VoltageTolerances

LARGEST_SHARE = 0.5
"""Largest tolerance of a voltage, as a share of it: beyond this the lower end is unusable."""


def _chains(controller: Controller) -> Iterator[tuple[str, Any]]:
    yield from controller.adc_sensors.items()


def tolerances_have_a_part(controller: Controller) -> Findings:
    """Find tolerances of parts that a chain does not have, or whose error cancels."""
    for name, sensor in _chains(controller):
        told, path = sensor.tolerances, ("sensors", name, "tolerances")
        if getattr(told, "beta_percent", None) is not None and not isinstance(
            sensor.curve, BetaCurve
        ):
            yield Finding(
                (*path, "beta"),
                "this curve has no beta",
                "Delete it, or write a curve with beta",
                (("sensors", name, "curve"),),
            )
        if getattr(told, "supply_v", None) is not None and hangs_on_supply(sensor):
            yield Finding(
                (*path, "supply"),
                "the divider and the ADC's reference are one supply, so its error cancels",
                "Delete it",
                (("sensors", name),),
            )


def tolerances_leave_a_voltage(controller: Controller) -> Findings:
    """Find tolerances that are more than half of the voltage."""
    for name, sensor in _chains(controller):
        told = sensor.tolerances
        voltages = {"reference": (told.reference_v, reference_v(sensor, controller.board.mcu))}
        if not isinstance(told, VoltageTolerances) and isinstance(told.supply_v, float):
            voltages["supply"] = told.supply_v, fed_v(sensor)
        for key, (tolerance_v, whole_v) in voltages.items():
            if tolerance_v is not None and tolerance_v > LARGEST_SHARE * whole_v:
                yield Finding(
                    ("sensors", name, "tolerances", key),
                    f"{number(tolerance_v)} V is more than half of the {number(whole_v)} V",
                    "Write the tolerance (how far it may deviate), not the voltage",
                    (("sensors", name), ("controller", "board")),
                )


def accuracy_within_range(controller: Controller) -> Findings:
    """Find an accuracy that is demanded outside the sensor's range."""
    for name, sensor in controller.thermometers.items():
        if not sensor.on_adc or sensor.accuracy is None:
            continue
        between_c, (low_c, high_c) = sensor.accuracy.between_c, sensor.range_c
        if between_c is not None and not low_c <= between_c[0] <= between_c[1] <= high_c:
            yield Finding(
                ("sensors", name, "accuracy", "between"),
                f"the sensor measures from {celsius(low_c)} to {celsius(high_c)}",
                "Use temperatures within its range",
                (("sensors", name, "range"),),
            )
