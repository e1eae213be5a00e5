"""The loops and parts of a host build, as macros for world.c and loop.c."""

from dataclasses import dataclass, fields
from importlib import import_module
from typing import NamedTuple

from heatwright.sim.native.parts import PARTS
from heatwright.sim.reference.numbers import TICK_US, period_us
from heatwright.spec import Controller, Loop, LoopFacts, facts_of
from heatwright.spec.board.timers import TICK_S, allocate, looks, looks_in_tick
from heatwright.spec.registry import module_of
from heatwright.spec.sensors import Thermometer

HOST_SHORTED = 2
"""As in world.h: a line shorted to ground."""

PORTS = "ABCDEFGHJKL"
"""The ports in the order of include/avr/io.h."""


class Watched(NamedTuple):
    """A monitor that is judged in a loop's steps."""

    name: str
    sensor: str
    values: str
    """The C type and the values of its readings."""
    table: bool
    """Whether a table converts the readings to temperatures."""


@dataclass(frozen=True, slots=True)
class Parts(LoopFacts):
    """A loop and its parts."""

    stepper: str | None
    ammeter: str | None
    """The sensor of the heater's current."""
    has_output_state: bool
    table: bool
    """Whether a table in its own file converts the sensor's readings to temperatures."""
    relay: str | None
    """The safety relay's output."""
    all_proven: tuple[str, ...]
    """All fans whose proof is checked in the steps of any loop."""
    watched: tuple[Watched, ...]


def monitor_readings(controller: Controller, name: str) -> tuple[int, ...]:
    """Return raw readings of a monitor: near both ends of the warning, and near the limit."""
    monitor = controller.monitors[name]
    sensor = controller.thermometers[monitor.sensor]
    ideal = import_module(module_of("sensor", "reference", sensor.kind)).IdealSensor(
        sensor, controller.board
    )
    ends_c = monitor.warning_c - monitor.hysteresis_k
    step_k = sensor.step_at_k(monitor.warning_c, controller.board.mcu)
    low_c, high_c = sensor.range_c
    wished = (
        *(ends_c + step_k * steps for steps in (-2, 0, 1)),
        *(monitor.warning_c + step_k * steps for steps in (-1, 0, 1)),
        *(monitor.limit_c + step_k * steps for steps in (-1, 0, 1)),
    )
    found = [ideal.read(min(max(each_c, low_c), high_c)) for each_c in wished]
    assert not any(status for status, _ in found)  # noqa: S101 - the checks ensure it
    return tuple(raw for _, raw in found)


def parts_of(controller: Controller) -> tuple[Parts, ...]:
    """Return the loops of a controller, in their order, with their parts."""
    return tuple(_parts(controller, facts_of(controller, name)) for name in controller.loops)


def _parts(controller: Controller, facts: LoopFacts) -> Parts:
    return Parts(
        **{each.name: getattr(facts, each.name) for each in fields(facts)},
        stepper=next(iter(controller.steppers), None),
        ammeter=facts.current.sensor if facts.current else None,
        has_output_state=not controller.outputs[facts.heater].is_on_off,
        table=controller.thermometers[facts.sensor].on_adc,
        relay=controller.safety.relay,
        all_proven=tuple(facts_of(controller).proofs),
        watched=tuple(
            Watched(
                each,
                monitor.sensor,
                f"{_raw_type(controller.thermometers[monitor.sensor])},"
                + ",".join(map(str, monitor_readings(controller, each))),
                controller.thermometers[monitor.sensor].on_adc,
            )
            for each, monitor in facts.monitored.items()
        ),
    )


def control_files(parts: Parts) -> list[str]:
    """Return the stems of the files that decide about a loop's heater."""
    return ["loop", "guard", "algorithm", *(["autotune"] if parts.autotune else [])]


def _raw_type(sensor: Thermometer) -> str:
    """Return the C type of a sensor's readings."""
    return f"int{sensor.reading_bits}_t"


def program_files(parts: Parts) -> list[str]:
    """Return the stems of the files that set the setpoint, each after those that it needs."""
    return ["programs", "progress", "program"] * parts.programmed


def names_for_world(controller: Controller, loops: tuple[Parts, ...]) -> list[str]:
    """Return gcc's options for world.c: the loops' names, and the parts that the loops share."""
    first = loops[0]
    flags = ["-DLOOPS=" + "".join(f"LOOP({parts.name})" for parts in loops)]
    headers = ["fault.h", "gate.h", "reset.h", "settings.h", "config.h", "pins.h"]
    for parts in loops:
        flags += ["-DPROGRAMMED"] * parts.programmed
        headers += [f"{name}.h" for name in program_files(parts)]
    flags.append(f"-DLOOKS={looks_of(controller)}")
    headers += [f"proof_{fan}.h" for fan in first.all_proven]
    flags += _proof_flags(controller) + _input_flags(controller)
    headers += ["inputs.h"] * bool(controller.safety.inputs)
    if first.stepper:
        flags.append(f"-DSTEPPER={first.stepper}")
        headers.append(f"output_{first.stepper}.h")
    if first.relay:
        flags += _line_flags(controller, "RELAY", first.relay)
        headers.append("relay.h")
    if controller.safety.relay_feedback:
        contact = controller.board.pins[controller.safety.relay_feedback]
        flags += [f"-DCONTACT_PORT={PORTS.index(contact.port)}"]
        flags += [f"-DCONTACT_MASK=(1u<<{contact.bit})"]
    return [*flags, *_included(headers)]


def looks_of(controller: Controller) -> int:
    """Return how often a tick reads the tachometers' lines; 1 if there are none."""
    return looks_in_tick(controller) if looks(controller) else 1


def healthy_line(controller: Controller, fan: str) -> int:
    """Return `proof_line` of world.h for a healthy fan: reads per pulse, or HOST_SHORTED."""
    counted = facts_of(controller).proofs[fan].tachometer
    if counted is None:
        return HOST_SHORTED
    return round(looks_of(controller) / TICK_S / counted.pulses_hz(counted.speed_rpm))


def _proof_flags(controller: Controller) -> list[str]:
    listed, counted = "", ""
    for fan, proof in facts_of(controller).proofs.items():
        pin = controller.board.pins[proof.pin]
        place = f"{PORTS.index(pin.port)},(1u<<{pin.bit}),{healthy_line(controller, fan)}"
        listed += f"PROOF({fan},{place})"
        if proof.tachometer is not None:
            counted += f"PROOF({fan},{proof.tachometer.window_ticks})"
    return [f"-DPROOFS={listed}"] * bool(listed) + [f"-DCOUNTED={counted}"] * bool(counted)


def _input_flags(controller: Controller) -> list[str]:
    pins = [controller.board.pins[each.pin] for each in controller.safety.inputs.values()]
    listed = "".join(
        f"INPUT({number},{PORTS.index(pin.port)},(1u<<{pin.bit}))"
        for number, pin in enumerate(pins)
    )
    return [f"-DINPUTS={listed}"] * bool(listed)


def names_for_loop(controller: Controller, parts: Parts) -> list[str]:
    """Return gcc's options for loop.c: the names of the loop and its parts."""
    control: Loop = controller.loops[parts.name]
    flags = [f"-DLOOP={parts.name}", f"-DSENSOR={parts.sensor}", f"-DHEATER={parts.heater}"]
    flags.append(f"-DRAW={_raw_type(controller.thermometers[parts.sensor])}")
    flags.append(f"-DPERIOD_TICKS={period_us(control) // TICK_US}u")
    flags += ["-DHOSTED"] * parts.hosted
    flags += ["-DSWITCHED"] * parts.switched + ["-DTUNABLE"] * parts.tunable
    flags += ["-DAUTOTUNE"] * parts.autotune + ["-DADJUSTABLE"] * parts.adjustable
    flags += ["-DLIMITS"] * parts.limits_adjustable + ["-DPROGRAMMED"] * parts.programmed
    if parts.keyed_numbers:
        flags.append(
            "-DNUMBERS=" + "".join(f"NUMBER({each.kind.field})" for each in parts.keyed_numbers)
        )
    headers = [f"{kind}_{parts.name}.h" for kind in control_files(parts)]
    headers += [f"{name}.h" for name in program_files(parts)]
    if parts.cooler:
        flags.append(f"-DCOOLER={parts.cooler}")
        headers.append(f"output_{parts.cooler}.h")
    if parts.ammeter:
        flags.append(f"-DCURRENT={parts.ammeter}")
        headers += [f"sensor_{parts.ammeter}.h", f"current_{parts.heater}.h"]
    headers += [f"sensor_{parts.sensor}.h", f"output_{parts.heater}.h"]
    headers += ["fault.h", "gate.h", "reset.h", "settings.h", "config.h", "pins.h"]
    if parts.response:
        flags.append("-DRESPONSE")
        headers.append(f"response_{parts.name}.h")
    if parts.watched:
        listed = "".join(
            f"MONITOR({sensor},{number},{types})"
            for number, (_, sensor, types, _) in enumerate(parts.watched, 1)
        )
        flags.append(f"-DMONITORS={listed}")
        flags.append("-DMONITORED=" + "".join(f"MONITOR({name})" for name, *_ in parts.watched))
        for name, sensor, *_ in parts.watched:
            headers += [f"sensor_{sensor}.h", f"monitor_{name}.h"]
    if parts.fan:
        flags += _line_flags(controller, "FAN", parts.fan)
        headers.append(f"output_{parts.fan}.h")
    if parts.has_output_state:
        flags.append("-DHAS_STATE")
    flags += _pwm_flags(controller, parts.heater)
    return [*flags, *_included(headers)]


def _included(headers: list[str]) -> list[str]:
    return [part for header in headers for part in ("-include", header)]


def _line_flags(controller: Controller, what: str, name: str) -> list[str]:
    """Return the options with a digital output's port and bit, and its inactive level."""
    output = controller.on_off_output(name)
    pin = controller.board.pins[output.pin]
    mask = f"(1u<<{pin.bit})"
    off = "0u" if output.active == "high" else mask
    place = [f"-D{what}={name}", f"-D{what}_PORT={PORTS.index(pin.port)}"]
    return [*place, f"-D{what}_MASK={mask}", f"-D{what}_OFF={off}"]


def _pwm_flags(controller: Controller, heater: str) -> list[str]:
    """Return the options with the registers that determine a PWM output's on-time."""
    pwm = allocate(controller).pwm.get(heater)
    if pwm is None:
        return []
    timer, channel = pwm.timer, pwm.channel
    old = PARTS[controller.board.mcu].old
    flags = [
        f"-DPWM_COMPARE=OCR{timer}{channel}",
        f"-DPWM_WHOLE=OUTPUT_{heater.upper()}_PERIOD_COUNTS",
    ]
    if pwm.by_interrupts:
        return [
            *flags,
            f"-DPWM_COUNT=TCNT{timer}",
            f"-DPWM_ENABLED=(TIMSK{'' if old else timer}&(1u<<OCIE{timer}{channel}))",
            f"-DPWM_INTERRUPT=TIMER{timer}_COMP{channel}_vect",
        ]
    letter = "" if old and not channel else "A"
    return [*flags, f"-DPWM_CONTROL=TCCR{timer}{letter}", f"-DPWM_BITS=(1u<<COM{timer}{channel}1)"]
