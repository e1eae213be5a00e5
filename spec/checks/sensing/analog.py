"""Sensors on the ADC: ranges that their circuits can show, and one reference for all of them."""

import math
from collections.abc import Iterator

from heatwright.spec.base import ABSOLUTE_ZERO_C
from heatwright.spec.checks.finding import Finding, Findings, limits_of
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import celsius, number
from heatwright.spec.sensing.analog_parts import CodesCurve, PointsCurve
from heatwright.spec.sensing.circuits import code_share, divider_v, reference_v
from heatwright.spec.sensing.conversion import CODES, LEAST_MARGIN_STEPS, Limits
from heatwright.spec.sensors import AdcThermometer

PLATINUM_C = (-200.0, 850.0)
"""Range in which IEC 60751 gives the curve of platinum."""


def analog_sensors(controller: Controller) -> Iterator[tuple[str, AdcThermometer]]:
    """List the thermometers on the ADC."""
    for name, sensor in controller.thermometers.items():
        if sensor.on_adc:
            yield name, sensor


def scales_are_not_zero(controller: Controller) -> Findings:
    """Find sensors whose voltage does not change with the temperature."""
    for name, sensor in analog_sensors(controller):
        if sensor.gives_voltage and sensor.scale_v_per_k == 0:
            yield Finding(
                ("sensors", name, "scale"),
                "at this scale the voltage does not change with the temperature",
                "Use the scale of the sensor, such as 10 mV/K",
            )


def ranges_have_curves(controller: Controller) -> Findings:
    """Find ranges outside the temperatures for which the sensing element's curve is known."""
    for name, sensor in analog_sensors(controller):
        (low_c, high_c), whose = _known(sensor)
        if _beyond(sensor):
            yield Finding(
                ("sensors", name, "range"),
                f"{whose} from {celsius(low_c)} to {celsius(high_c)}",
                f"Use a range within {celsius(low_c)} .. {celsius(high_c)}",
                (("sensors", name),),
            )


def codes_are_of_the_circuit(controller: Controller) -> Findings:
    """Find tables of codes that the divider cannot give, or whose reference is not known."""
    for name, sensor in analog_sensors(controller):
        if not isinstance(sensor.curve, CodesCurve):
            continue
        if sensor.reference == "internal":
            yield Finding(
                ("sensors", name, "reference"),
                "a table of codes is valid for one reference voltage, and the internal one differs "
                "from chip to chip",
                "Use the reference that the table was made with: supply, or the voltage at AREF",
                (("sensors", name),),
            )
            continue
        if _above_supply(sensor, controller.board.mcu):
            share = divider_v(sensor.divider) / reference_v(sensor, controller.board.mcu)
            readings = sensor.curve.readings
            summed = f"a sum of {readings} readings" if readings > 1 else "one reading"
            yield Finding(
                ("sensors", name, "curve", "codes"),
                f"in {summed} the divider's supply gives code "
                f"{readings * (1024 * share - 0.5):.1f}, and no code can be higher",
                "Correct the codes, the readings, or the divider's supply",
                (("sensors", name),),
            )


def _above_supply(sensor: AdcThermometer, mcu: str) -> bool:
    """Return whether a table has a code that its divider can never give: it is above the supply."""
    if not isinstance(sensor.curve, CodesCurve):
        return False
    highest = max(code for code, _ in sensor.curve.codes)
    share = divider_v(sensor.divider) / reference_v(sensor, mcu)
    return code_share(highest, sensor.curve.readings) >= share


def _beyond(sensor: AdcThermometer) -> bool:
    (low_c, high_c), _ = _known(sensor)
    return sensor.range_c[0] < low_c or sensor.range_c[1] > high_c


def _known(sensor: AdcThermometer) -> tuple[tuple[float, float], str]:
    """Return the ends of an element's curve, and words for a message about them."""
    if sensor.gives_voltage:
        return (ABSOLUTE_ZERO_C, math.inf), ""
    if sensor.curve is None:
        if sensor.alpha_ppm_per_k is not None:
            return PLATINUM_C, "platinum thermometers are used"
        return PLATINUM_C, "IEC 60751 gives the resistance of platinum"
    if isinstance(sensor.curve, PointsCurve):
        temperatures_c = [point[0] for point in sensor.curve.points]
        return (min(temperatures_c), max(temperatures_c)), "the curve's points go"
    if isinstance(sensor.curve, CodesCurve):
        temperatures_c = [pair[1] for pair in sensor.curve.codes]
        return (min(temperatures_c), max(temperatures_c)), "the table of codes goes"
    return (ABSOLUTE_ZERO_C, math.inf), ""


def ranges_can_be_shown(controller: Controller) -> Findings:
    """Find ranges at whose ends the voltage could also be that of an open or shorted sensor."""
    for name, sensor in analog_sensors(controller):
        found = limits_of(sensor, controller.board.mcu)
        if (found is None or not found.shown) and not _already_wrong(sensor, controller.board.mcu):
            yield Finding(
                ("sensors", name, "range"),
                *_reason(sensor, controller.board.mcu, found),
                (("sensors", name), ("controller", "board")),
            )


def _already_wrong(sensor: AdcThermometer, mcu: str) -> bool:
    """Return whether another check in this module already reports this sensor."""
    if _above_supply(sensor, mcu):
        return True
    return (sensor.gives_voltage and sensor.scale_v_per_k == 0) or _beyond(sensor)


def _reason(sensor: AdcThermometer, mcu: str, found: Limits | None) -> tuple[str, str]:
    if found is None:
        return "no reading can be computed at an end of this range", "Use the range that is needed"
    shown_c = _widest_c(sensor, mcu, found)
    if shown_c is None or shown_c[0] >= shown_c[1]:
        return "with these values the circuit shows no temperature", "Check the circuit's values"
    low_c, high_c = (celsius(end_c) for end_c in shown_c)
    margin = min(found.low - found.low_limit, found.high_limit - found.high)
    if found.high - found.low < LEAST_MARGIN_STEPS <= margin:
        return (
            f"the whole range is less than {LEAST_MARGIN_STEPS} steps of the ADC",
            f"Use a range of {low_c} .. {high_c}, or a circuit that shows more of it",
        )
    return (
        f"the circuit shows {low_c} to {high_c}, with {LEAST_MARGIN_STEPS} steps of the ADC left "
        "at each end to detect an open or a shorted sensor",
        f"Use a range within {low_c} .. {high_c}, or a circuit that shows more",
    )


def _widest_c(sensor: AdcThermometer, mcu: str, found: Limits) -> tuple[float, float] | None:
    """Find the widest range that the circuit shows, in whole degrees."""
    chain = sensor.circuit(mcu)
    first, last = found.low_limit + LEAST_MARGIN_STEPS, found.high_limit - LEAST_MARGIN_STEPS
    try:
        low_c, high_c = sorted((chain.celsius(first / CODES), chain.celsius(last / CODES)))
    except (ArithmeticError, ValueError):
        return None
    return float(max(math.ceil(low_c), math.ceil(ABSOLUTE_ZERO_C))), float(math.floor(high_c))


def one_reference(controller: Controller) -> Findings:
    """Find sensors that need another reference of the ADC than earlier sensors, or the keypad."""
    first: tuple[Path, str, str] | None = None
    for index, interface in enumerate(controller.interfaces):
        if interface.shield is not None:
            first = ("interfaces", index), "the keys of the shield", "supply"
    for name, sensor in controller.adc_sensors.items():
        path = ("sensors", name, "reference")
        wanted = _shown(sensor.reference)
        if first is None:
            first = path[:2], name, wanted
        elif first[2] != wanted:
            yield Finding(
                path,
                f"the ADC has one reference for all inputs, and {first[1]} "
                f"{'need' if first[0][0] == 'interfaces' else 'needs'} reference: {first[2]}",
                f"Write reference: {first[2]} here too",
                (first[0], ("interfaces",)),
            )


def _shown(reference: float | str) -> str:
    return reference if isinstance(reference, str) else f"{number(reference)} V"
