"""Facts that follow from a spec, for its controller and each of its loops: computed once.

Every layer reads them, after the checks; `spec/` itself reads the models they are computed from.

Facts are statements about the spec. The calculations that use them are written anew in each layer:
a reference model that shared the firmware's calculations would prove nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import overload
from weakref import finalize

from heatwright.spec import commands, self_checks
from heatwright.spec.adjusted import GAINS, Number, numbers_of
from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.breakable import rules_of
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Countdown, Gcode, LcdKeypad, ModbusRtu, Nextion, SerialLog
from heatwright.spec.monitors import Input, Monitor, tripping, watching_loop
from heatwright.spec.outputs import Proof
from heatwright.spec.proofs import proofs
from heatwright.spec.rules import Rule
from heatwright.spec.sensing.currents import Current

_KNOWN: dict[int, ControllerFacts] = {}
"""Facts of each existing controller, by its `id()`: a changed copy has its own."""


@dataclass(frozen=True, slots=True)
class ControllerFacts:
    """The facts of a whole controller."""

    loops: Mapping[str, LoopFacts]
    # The first interface of each kind.
    gcode: Gcode | None
    keypad: LcdKeypad | None
    log: SerialLog | None
    modbus: ModbusRtu | None
    nextion: Nextion | None
    # What can trip.
    rules: tuple[Rule, ...]
    """The rules that can trip, in the order of their codes."""
    proofs: Mapping[str, Proof]
    """The proofs of loops' fans, by output."""
    tripping_inputs: Mapping[str, Input]
    """The inputs that are a fault when they open."""
    # Its self-checks.
    checked: bool
    """The controller checks itself."""
    proves_watchdog: bool
    """The start tests the watchdog by a reset."""
    measures_known_voltage: bool
    """The ADC also measures a known voltage."""
    read_back: tuple[str, ...]
    """Outputs whose pins are read back, except while they pulse."""


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
    gains_vary: bool
    """The loop's gains are set by command, or some of them at the keypad."""
    autotune: bool
    """A command can start the experiment that finds the loop's gains."""
    programmed: bool
    """Programs set the loop's setpoint."""
    minds_host: bool
    """The loop trips when the host that commands it sends nothing for too long."""
    must_release: bool
    """The loop needs a command "off" before it accepts an "on": a master repeats its commands, and
    a repeated "on" must not restart a heater. A person presses a button on purpose."""
    starts_enabled: bool
    keyed: bool
    """The keypad of the display shield serves the loop."""
    touched: bool
    """A touch display serves the loop."""
    plotted: bool
    """The loop's numbers are sent to a plotter."""
    countdown: Countdown | None
    """The operator sets a time after which the loop goes off."""
    lit: frozenset[str]
    """States of the loop that LEDs show."""
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
    """Fans whose proof the loop's step checks: the first loop that names a fan checks it."""
    fan_proven: bool
    monitored: Mapping[str, Monitor]
    """Monitors that the loop's step checks."""
    monitors: tuple[str, ...]
    """Names of these monitors, without `also`."""
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


@overload
def facts_of(controller: Controller) -> ControllerFacts: ...
@overload
def facts_of(controller: Controller, loop: str) -> LoopFacts: ...
def facts_of(controller: Controller, loop: str | None = None) -> ControllerFacts | LoopFacts:
    """Return the facts of a checked controller, or of one of its loops."""
    if (known := _KNOWN.get(id(controller))) is None:
        known = _KNOWN[id(controller)] = _found(controller)
        finalize(controller, _KNOWN.pop, id(controller))
    return known if loop is None else known.loops[loop]


def _found(controller: Controller) -> ControllerFacts:
    return ControllerFacts(
        loops=ReadOnlyDict({name: _of_loop(controller, name) for name in controller.loops}),
        gcode=commands.gcode_of(controller),
        keypad=commands.keypad_of(controller),
        log=commands.log_of(controller),
        modbus=commands.modbus_of(controller),
        nextion=commands.nextion_of(controller),
        rules=rules_of(controller),
        proofs=ReadOnlyDict(proofs(controller)),
        tripping_inputs=ReadOnlyDict(tripping(controller)),
        checked=controller.safety.self_checks,
        proves_watchdog=self_checks.proves_watchdog(controller),
        measures_known_voltage=self_checks.measures_known_voltage(controller),
        read_back=self_checks.read_back(controller),
    )


def _of_loop(controller: Controller, name: str) -> LoopFacts:
    loops = controller.loops
    loop, proven = loops[name], proofs(controller)
    commanded = commands.commanded(controller, name)
    switched = commands.switched(controller, name)
    tunable = commands.tunable(controller, name)
    outputs, is_first = controller.outputs, name == next(iter(loops))
    master_lost = loop.protection.master_lost_after_s is not None
    numbers, lit = numbers_of(controller, name), commands.shown_meanings(controller, name)
    first_with = {each.fan: user for user, each in reversed([*loops.items()])}
    monitored = {
        each: monitor
        for each, monitor in controller.monitors.items()
        if watching_loop(controller, each) == name
    }
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
        gains_vary=tunable or any(each.kind.key in GAINS for each in numbers),
        autotune=tunable and loop.autotune is not None,
        programmed=commands.programmed(controller, name),
        minds_host=master_lost and commands.by_host(controller, name),
        must_release=commands.modbus_of(controller) is not None,
        starts_enabled=commands.starts_enabled(controller, name),
        keyed=commands.keyed(controller, name),
        touched=commands.touched(controller, name),
        plotted=commands.plotted(controller, name),
        countdown=commands.countdown_of(controller, name),
        lit=lit,
        has_state=switched or bool(lit),
        stored=loop.setpoint.stored,
        lasting=commanded and not switched and tunable and loop.setpoint.stored,
        adjustable=loop.protection.maximum_adjustable,
        limits_adjustable=loop.algorithm.limits_adjustable,
        keyed_numbers=numbers,
        readings=controller.thermometers[loop.sensor].moving_average,
        inputs=bool(controller.safety.inputs),
        inputs_judged=is_first and bool(tripping(controller)),
        relay_judged=is_first and controller.safety.relay_feedback is not None,
        wants_relay=commanded and controller.safety.relay is not None,
        proven=tuple(fan for fan in proven if first_with[fan] == name),
        fan_proven=loop.fan in proven,
        monitored=ReadOnlyDict(monitored),
        monitors=tuple(each for each in monitored if each != loop.also),
        master_lost=master_lost,
        on_limited=loop.protection.on_for_at_most_s is not None,
        current=outputs[loop.heater].current,
        heater_holds=outputs[loop.heater].stays_on_s > 0,
        response=loop.response is not None,
        checked=controller.safety.self_checks,
    )
