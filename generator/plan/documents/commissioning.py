"""The tests before a machine heats for the first time: their order and expected results."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from heatwright.generator.plan.numbers import TICK_MS, quantity
from heatwright.generator.plan.parts import Wiring
from heatwright.generator.plan.pins import label
from heatwright.generator.plan.protection.limits import READINGS
from heatwright.spec import Controller, Loop, facts_of
from heatwright.spec.outputs import Switch
from heatwright.spec.sensing.budget import budget
from heatwright.spec.sensing.circuits import SUPPLY_V, reference_v
from heatwright.spec.sensors import Thermometer

ROOM_C = 20.0
USUAL_V = (12.0, 24.0, 120.0, 230.0)
"""Usual supply voltages, for heaters whose spec gives none."""
OHM_TOLERANCE = "10 %"
"""Tolerance of a heater's cold resistance: tolerances of the part and of the meter."""


class Step(NamedTuple):
    """One action, and its expected result."""

    do: str
    see: str


class Stage(NamedTuple):
    """The steps in one state of the machine."""

    title: str
    steps: tuple[Step, ...]


def commissioning(controller: Controller, rows: Sequence[Wiring]) -> list[Stage]:
    """List the stages in their order: each is safe after the stages before it."""
    stages = (
        ("Nothing has power: an ohmmeter", (*_pulls(rows), *_loads(controller))),
        ("The board has power, the loads have none", tuple(_board(controller))),
        ("A lamp in the place of each heater", tuple(_lamp(controller))),
        ("The first heating: a second thermometer at the sensor, a person at the mains switch",
         tuple(_heating(controller))),
    )  # fmt: skip
    return [Stage(title, steps) for title, steps in stages]


def _codes(controller: Controller, *rules: str) -> str:
    """Return the codes of the given rules that this controller has, as the display shows them."""
    found = [f"E{rule.code:02d}" for rule in facts_of(controller).rules if rule.id in rules]
    return " or ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)


def _heaters(controller: Controller) -> dict[str, Switch]:
    names = dict.fromkeys(loop.heater for loop in controller.loops.values())
    return {name: controller.switches[name] for name in names}


def _pulls(rows: Sequence[Wiring]) -> Iterator[Step]:
    """Measure pull-up and pull-down resistors, except in a divider: its sensor is in parallel."""
    for row in rows:
        for each in row.symbols:
            divides = any(other.shape == "sensor" for other in row.symbols)
            if each.shape == "resistor" and each.way != "along" and not divides:
                rail = "ground" if each.way == "down" else f"the {each.rail} rail"
                yield Step(f"Measure from {row.pin} to {rail}", f"about {each.text}")


def _loads(controller: Controller) -> Iterator[Step]:
    relay, board = controller.safety.relay, controller.board
    for name, output in _heaters(controller).items():
        yield Step(f"Measure heater `{name}` at its terminals", _ohm(output))
        yield Step(f"Measure from either terminal of `{name}` to its metal case", "more than 1 MΩ")
    for name, loop in controller.loops.items():
        hottest = quantity(loop.protection.maximum_c, "°C")
        yield Step(
            f"Read the label of loop `{name}`'s thermal fuse or thermostat; measure its resistance",
            f"it opens above {hottest}, the firmware's limit, and below the temperature that the "
            "machine withstands; less than 1 Ω",
        )
    if relay is not None:
        yield Step(f"Measure across the contacts of `{relay}` in the heaters' supply", "open")
    if controller.safety.relay_feedback is not None:
        pin = label(board.pins[controller.safety.relay_feedback])
        yield Step(f"Measure the mirror contact, from {pin} to ground", "closed")
    for name, each in controller.safety.inputs.items():
        yield Step(
            f"Measure contact `{name}`, from {label(board.pins[each.pin])} to ground, and open it",
            "closed, then open",
        )


def _ohm(output: Switch) -> str:
    """Return the resistance of a heater, from its power and voltage."""
    power_w, volts = output.power_w, output.rated_v or output.supply_v
    if power_w is None:
        return "the resistance in its data sheet"
    if volts is not None:
        return f"{volts**2 / power_w:.3g} Ω ± {OHM_TOLERANCE}"
    usual = ", ".join(f"{each**2 / power_w:.3g} Ω at {each:g} V" for each in USUAL_V)
    return f"{usual} (± {OHM_TOLERANCE})"


def _board(controller: Controller) -> Iterator[Step]:
    board = controller.board
    for name, output in controller.switches.items():
        if not output.always_runs:
            pin, off_v = label(board.pins[output.pin]), SUPPLY_V if output.active == "low" else 0.0
            yield Step(
                f"Hold the reset button, and let it go: measure {pin} (`{name}`)",
                f"{quantity(off_v, 'V')} all the time",
            )
    for name, sensor in controller.thermometers.items():
        yield Step(
            f"Read sensor `{name}` in a room of {quantity(ROOM_C, '°C')}",
            f"{quantity(ROOM_C, '°C')} ± {_off_by(controller, sensor, ROOM_C)}",
        )
    for name, chain in controller.adc_sensors.items():
        if not chain.measures_current:
            volts = chain.circuit(board.mcu).ratio(ROOM_C) * reference_v(chain, board.mcu)
            pin = label(board.pins[chain.pin])
            seen = f"about {volts:.3g} V"
            amplifier = None if chain.gives_voltage else chain.amplifier
            if amplifier is not None and amplifier.feed == "constant_current":
                seen += "; less: the element's current is not constant, all readings are too low"
            yield Step(f"Measure {pin} (`{name}`) at {quantity(ROOM_C, '°C')}", seen)
    for name, loop in controller.loops.items():
        seconds = loop.next_step_s(loop.protection.stale_after_s) + TICK_MS / 1000
        yield Step(
            f"Loop `{name}` on: pull the sensor's plug",
            f"{_codes(controller, *READINGS)} within {seconds:.3g} s; plug it in and acknowledge",
        )
    for name, proof in facts_of(controller).proofs.items():
        yield Step(
            f"Stop `{name}` by hand",
            f"{_codes(controller, 'fan_stopped')} within {quantity(proof.within_s, 's')}",
        )
    for name, each in controller.safety.inputs.items():
        seen = _codes(controller, "input_open") if each.trips else "the loops pause: heaters off"
        yield Step(f"Open contact `{name}`", seen)


def _off_by(controller: Controller, sensor: Thermometer, at_c: float) -> str:
    """Return the tolerance of a reading: for a chain of parts, the sum of their tolerances."""
    if not sensor.on_adc:
        return f"{sensor.error_k(at_c):.2g} K"
    parts = budget(sensor, controller.board.mcu, (at_c,))
    untold = f", and unknown tolerances ({', '.join(parts.untold)})"
    return f"{parts.worst[0]:.2g} K{untold if parts.untold else ''}"


def _lamp(controller: Controller) -> Iterator[Step]:
    relay = controller.safety.relay
    for name, loop in controller.loops.items():
        first = "" if relay is None else f"`{relay}` closes first, then "
        yield Step(
            f"Loop `{name}` on, setpoint above the reading",
            f"{first}the lamp is lit{_not_a_heater(controller, loop)}",
        )
        yield Step("Hold the reset button", "the lamp goes off at once, and stays off")
        seconds = loop.next_step_s(loop.protection.stale_after_s) + TICK_MS / 1000
        yield Step(
            "Lamp lit again: pull the sensor's plug", f"off within {seconds:.3g} s, and stays off"
        )
        if loop.fan is not None:
            yield Step(f"Loop off: look at `{loop.fan}`", "it turns, and moves air over the heater")


def _not_a_heater(controller: Controller, loop: Loop) -> str:
    """Name the faults that are correct while a lamp is connected instead of the heater."""
    heating, measured = loop.protection.heating, controller.switches[loop.heater].current
    seen = _codes(controller, "no_current", "over_current") if measured is not None else ""
    told = f"; {seen} is correct: a lamp has another current" if seen else ""
    if heating is None:
        return told
    code, late = _codes(controller, "heating_failed"), quantity(heating.within_s, "s")
    return f"{told}; {code} after {late} is correct: a lamp heats nothing"


def _after_power(controller: Controller, name: str) -> str:
    """Say what a loop does when the power returns."""
    setpoint = controller.loops[name].setpoint
    off = not setpoint.stored and setpoint.initial_c == 0 and facts_of(controller, name).hosted
    if off or not facts_of(controller, name).starts_enabled:
        return f"`{name}` is off until somebody switches it on"
    at = "its setpoint of before" if setpoint.stored else quantity(setpoint.initial_c, "°C")
    return f"`{name}` is on again, at {at}"


def _heating(controller: Controller) -> Iterator[Step]:
    for name, loop in controller.loops.items():
        heating = loop.protection.heating
        if heating is not None:
            yield Step(
                f"Loop `{name}` at full power from cold",
                f"a rise of at least {quantity(heating.rise_k, 'K')} in every "
                f"{quantity(heating.within_s, 's')}, else {_codes(controller, 'heating_failed')}",
            )
        off_by = _off_by(controller, controller.thermometers[loop.sensor], loop.setpoint.maximum_c)
        yield Step(
            "At the setpoint: compare both thermometers",
            f"they differ by at most {off_by}, plus the tolerance of the second one",
        )
        yield Step("Take all power away for ten seconds", _after_power(controller, name))
    yield Step("Stay with the machine for the first runs", "no code, no smell, no part too hot")
