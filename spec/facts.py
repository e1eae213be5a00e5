"""Facts that follow from a spec for each of its loops: computed once, read by every layer.

Facts are statements about the spec. The calculations that use them are written anew in each layer:
a reference model that shared the firmware's calculations would prove nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import finalize

from heatwright.spec import commands
from heatwright.spec.adjusted import Number, numbers_of
from heatwright.spec.controller import Controller
from heatwright.spec.monitors import monitors_of, tripping
from heatwright.spec.proofs import proofs, proven_in
from heatwright.spec.self_checks import self_checked
from heatwright.spec.sensing.currents import Current

_KNOWN: dict[int, dict[str, LoopFacts]] = {}
"""Facts of each existing controller, by its `id()`: a changed copy has its own."""


@dataclass(frozen=True, slots=True)
class LoopFacts:
    """The facts of one loop; templates use the same names."""

    name: str
    sensor: str
    heater: str
    cooler: str | None
    fan: str | None
    also: str | None
    """The second sensor of the loop, a monitor."""
    # Who commands the loop, and how.
    commanded: bool
    """A host, a master or a person sets the setpoint, and may switch it off."""
    switched: bool
    """The loop is enabled and disabled apart from its setpoint."""
    hosted: bool
    """A host commands the loop by its setpoint alone, 0 for off."""
    tunable: bool
    """The loop's gains are set by command, and its duty by hand."""
    autotune: bool
    """A command can start the experiment that finds the loop's gains."""
    programmed: bool
    """Programs set the loop's setpoint."""
    must_release: bool
    """The loop needs a command "off" before it accepts an "on"."""
    starts_enabled: bool
    keyed: bool
    """The keypad of the display shield serves the loop."""
    touched: bool
    """A touch display serves the loop."""
    plotted: bool
    """The loop's numbers are sent to a plotter."""
    countdown: bool
    """The operator sets a time after which the loop goes off."""
    has_state: bool
    """The loop reports whether it works, heats, cools and is warm: it is switched, or has LEDs."""
    # Settings, and those that survive a loss of power.
    stored: bool
    """The loop's setpoint survives a loss of power."""
    lasting: bool
    """The loop stores 0 instead of its setpoint unless its mode is automatic."""
    adjustable: bool
    """The operator may lower the critical temperature."""
    limits_adjustable: bool
    """A host may narrow the limits of the loop's integral and output."""
    keyed_numbers: tuple[Number, ...]
    """Numbers of the loop's algorithm that the keypad sets."""
    # Additions to its control step.
    readings: int
    """How many readings are in the mean that the control uses."""
    inputs: bool
    """The machine has inputs: while one is open, the loop does not heat."""
    inputs_judged: bool
    """The loop's step checks the inputs that trip: only the first loop's does."""
    relay_judged: bool
    """The loop's step checks the relay's contact: only the first loop's does."""
    wants_relay: bool
    """The loop can be off, and while it is off the relay may open."""
    proven: tuple[str, ...]
    """Fans whose proof the loop's step checks."""
    fan_proven: bool
    monitors: tuple[str, ...]
    """Monitors, in addition to `also`, that the loop's step checks."""
    master_lost: bool
    on_limited: bool
    """The loop has an `on_for_at_most`."""
    current: Current | None
    """The heater's `current` in the spec: its sensor and limits, if it is measured."""
    heater_holds: bool
    """The loop's heater has a shortest time on, which a trip has to end."""
    response: bool
    """Settling time and overshoot of its last setpoint are measured."""
    checked: bool
    """The controller checks itself."""


def facts_of(controller: Controller, name: str) -> LoopFacts:
    """Return the facts of one loop of a checked controller."""
    if (known := _KNOWN.get(id(controller))) is None:
        known = {each: _found(controller, each) for each in controller.loops}
        _KNOWN[id(controller)] = known
        finalize(controller, _KNOWN.pop, id(controller))
    return known[name]


def _found(controller: Controller, name: str) -> LoopFacts:
    loop = controller.loops[name]
    commanded = commands.commanded(controller, name)
    switched = commands.switched(controller, name)
    tunable = commands.tunable(controller, name)
    outputs, is_first = controller.outputs, name == next(iter(controller.loops))
    proven = proofs(controller)
    return LoopFacts(
        name=name,
        sensor=loop.sensor,
        heater=loop.heater,
        cooler=loop.cooler,
        fan=loop.fan,
        also=loop.also,
        commanded=commanded,
        switched=switched,
        hosted=commanded and not switched,
        tunable=tunable,
        autotune=tunable and loop.autotune is not None,
        programmed=commands.programmed(controller, name),
        must_release=switched and commands.must_release(controller),
        starts_enabled=commands.starts_enabled(controller, name),
        keyed=commands.keyed(controller, name),
        touched=commands.touched(controller, name),
        plotted=commands.plotted(controller, name),
        countdown=commands.countdown_of(controller, name) is not None,
        has_state=switched or bool(commands.shown_meanings(controller, name)),
        stored=loop.setpoint.stored,
        lasting=commanded and not switched and tunable and loop.setpoint.stored,
        adjustable=loop.protection.maximum_adjustable,
        limits_adjustable=loop.algorithm.limits_adjustable,
        keyed_numbers=numbers_of(controller, name),
        readings=controller.thermometers[loop.sensor].moving_average,
        inputs=bool(controller.safety.inputs),
        inputs_judged=is_first and bool(tripping(controller)),
        relay_judged=is_first and controller.safety.relay_feedback is not None,
        wants_relay=commanded and controller.safety.relay is not None,
        proven=tuple(proven_in(controller, name)),
        fan_proven=loop.fan in proven,
        monitors=tuple(each for each in monitors_of(controller, name) if each != loop.also),
        master_lost=loop.protection.master_lost_after_s is not None,
        on_limited=loop.protection.on_for_at_most_s is not None,
        current=outputs[loop.heater].current,
        heater_holds=outputs[loop.heater].stays_on_s > 0,
        response=loop.response is not None,
        checked=self_checked(controller),
    )
