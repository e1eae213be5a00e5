"""Common parts of the plans of all outputs."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from heatwright.generator.plan.numbers import quantity
from heatwright.generator.plan.parts import (
    PULL_OHM,
    Call,
    Constant,
    File,
    Group,
    Part,
    Symbol,
    Told,
    Wiring,
    along,
    pulled,
)
from heatwright.generator.plan.pins import label, switched
from heatwright.generator.plan.source import Source
from heatwright.spec import Controller, facts_of
from heatwright.spec.board.pwm_timers import PwmChannel
from heatwright.spec.outputs import Switch


@dataclass(frozen=True, slots=True)
class UseOfOutput:
    """How the firmware uses an output, and the timer that drives it."""

    heats: bool
    """True if it is the heater of a loop, so that the gate switches it."""
    commanded: bool
    """True if the host switches it: a fan of a `gcode` interface."""
    channel: PwmChannel | None = None
    """The timer's channel that makes a PWM."""
    timer: int | None = None
    """Number of the timer of a stepper."""
    cools: bool = False
    """True if it is the cooler of a loop, which the gate switches after the heater."""
    watched: bool = False
    """True if other code reads whether it is on."""

    @property
    def gated(self) -> bool:
        """True if the gate switches it."""
        return self.heats or self.cools


def cools(controller: Controller, name: str) -> bool:
    """Return whether an output is a loop's cooler."""
    return any(loop.cooler == name for loop in controller.loops.values())


def watched(controller: Controller, name: str) -> bool:
    """Return whether the gate (of a loop with a cooler) or LEDs read if an output is on."""
    return any(
        (loop.cooler is not None and name in {loop.heater, loop.cooler})
        or (loop.heater == name and "heating" in loop.lit)
        for loop in facts_of(controller).loops.values()
    )


@dataclass(frozen=True, slots=True)
class OutputNames:
    """The values for every output's template."""

    name: str
    prefix: str
    where: str
    heats: bool
    gated: bool
    commanded: bool
    watched: bool
    stops: bool
    """True for a heater with a minimum time on: it needs a function that switches it off sooner."""
    runs_where: str


def output_names(source: Source, name: str, use: UseOfOutput) -> OutputNames:
    """Return the values for every output's template."""
    output = source.controller.switches.get(name)
    return OutputNames(
        name=name,
        prefix=f"OUTPUT_{name.upper()}",
        where=source.where,
        heats=use.heats,
        gated=use.gated,
        commanded=use.commanded,
        watched=use.watched,
        stops=use.heats and output is not None and output.stays_on_s > 0,
        runs_where=source.at("runs").where,
    )


def output_part(  # noqa: PLR0913 - all values of one part
    source: Source,
    name: str,
    output: Switch,
    use: UseOfOutput,
    template: str,
    *,
    header: str = "",
    constants: tuple[Constant, ...] = (),
    told: Told = (),
    start_calls: tuple[Call, ...] = (),
    tick_calls: tuple[Call, ...] = (),
    wired: str = "",
    connected: tuple[str, ...] = (),
    pulses: str = "",
) -> Part:
    """Plan an output of one pin.

    told -- further values for the templates; header -- the header's template, if it differs from
    the source's; wired -- further text for the README; connected -- statements that disconnect the
    pin from timers: after a restart without a reset, the timers are as the program left them;
    pulses -- C expression that is not 0 while something else than the tick switches the pin.
    """
    pin = source.controller.board.pins[output.pin]
    stem = f"pin_output_{name}"
    values = output_names(source, name, use), told
    return Part(
        files=(
            File(f"src/output_{name}.h", f"{header or template}.h.j2", values),
            File(f"src/output_{name}.c", f"{template}.c.j2", values),
        ),
        groups=(Group(f"Output {name}", constants),) if constants else (),
        pins=(
            switched(
                source.at("pin"),
                f"output_{name}",
                pin,
                output.active,
                f"output {name}",
                released=use.heats and facts_of(source.controller).checked,
                read_back=name in facts_of(source.controller).read_back,
                pulses=pulses,
            ),
        ),
        start_calls=start_calls,
        tick_calls=tick_calls,
        wiring=(wiring(source, name, output, wired),),
        reset_lines=(*connected, f"{stem}_off();", f"{stem}_drive();") if use.gated else (),
    )


def wiring(source: Source, name: str, output: Switch, wired: str = "") -> Wiring:
    """Describe how an output of one pin is connected."""
    power = f", {quantity(output.power_w, 'W')}" if output.power_w is not None else ""
    pull: Literal["up", "down"] = "down" if output.active == "high" else "up"
    return Wiring(
        label(source.controller.board.pins[output.pin]),
        f"output `{name}`: {output.kind}{power}{wired}",
        f"active {output.active}; {PULL_OHM} pull it {pull} while the chip is in reset",
        (pulled(pull), *_load(source.controller, name, output, power)),
        ends=False,
    )


def _load(controller: Controller, name: str, output: Switch, power: str) -> Iterator[Symbol]:
    """Draw a load's circuit, from its switch to its supply: also current sensor, fuse and relay."""
    if output.frequency_hz > 0:
        yield along("transistor")
    else:
        yield along("solid-state relay" if output.is_windowed else "switch")
    relay = controller.safety.relay
    yield along(f"coil of {name}" if name == relay else f"{name}{power}")
    if output.current is not None:
        yield along(f"{output.current.sensor}")
    if any(name == loop.heater for loop in controller.loops.values()):
        yield Symbol("along", "fuse", "thermal fuse")
        if relay is not None:
            yield Symbol("along", "contact", relay)
    yield Symbol("along", "rail", f"{output.supply_v:g} V" if output.supply_v else "supply")
