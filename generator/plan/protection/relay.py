"""The safety relay in series with the heaters, and the contact that shows its state."""

from dataclasses import dataclass

from heatwright.generator.plan.numbers import TICK_MS
from heatwright.generator.plan.outputs.common import wiring
from heatwright.generator.plan.parts import Call, Constant, Group, Part, Stage, Symbol, Wiring, pair
from heatwright.generator.plan.pins import label, lifted, switched
from heatwright.generator.plan.source import Source
from heatwright.spec import facts_of

SETTLE_TICKS = 5
"""Time until the relay is surely closed: a power relay needs 15 ms with bouncing (TE T9A, data
sheet), a contactor of 9 A with a 24 V DC coil 35 ms to 60 ms (Siemens 3RT201, manual of 2011)."""
CONTACT_TICKS = 10
"""Time for the mirror contact to follow: a contactor of 25 A closes within 90 ms (3RT202)."""


@dataclass(frozen=True, slots=True)
class RelayNames:
    """The values for the templates of the relay."""

    name: str
    where: str
    feedback: bool
    feedback_where: str


def plan(root: Source, name: str) -> Part:
    """Plan the relay; `name` is its output."""
    controller = root.controller
    output = controller.on_off_output(name)
    source = root.at("outputs", name)
    relay, contact = root.at("safety", "relay"), root.at("safety", "relay_feedback")
    feedback = controller.safety.relay_feedback
    context = RelayNames(name, relay.where, feedback is not None, contact.where)
    pin = controller.board.pins[output.pin]
    checked, what = facts_of(controller).checked, "the safety relay"
    pins = [
        switched(
            source.at("pin"),
            f"output_{name}",
            pin,
            output.active,
            what,
            released=checked,
            read_back=checked,
        )
    ]
    wired = [wiring(source, name, output, ", the safety relay, in series with every heater")]
    if feedback is not None:
        mirror = controller.board.pins[feedback]
        pins.append(lifted(contact, "relay_contact", mirror, "mirror contact of the relay"))
        how = "its mirror contact to ground: closed while the relay is open"
        closes = Symbol("down", "closed", "mirror contact, normally closed")
        wired.append(Wiring(label(mirror), f"output `{name}`", how, (closes,), ends=False))
    return Part(
        files=pair("relay", "protection/relay", context),
        groups=(Group("Safety relay", _constants(relay, contact)),),
        pins=tuple(pins),
        start_calls=(Call(Stage.SENSE, "relay.h", "relay_start();"),) if feedback else (),
        wiring=tuple(wired),
        reset_lines=(f"pin_output_{name}_off();", f"pin_output_{name}_drive();"),
    )


def _constants(relay: Source, contact: Source) -> tuple[Constant, ...]:
    closed = f"closed for {SETTLE_TICKS * TICK_MS} ms before a heater goes on"
    settle = relay.count("RELAY_SETTLE_TICKS", SETTLE_TICKS, closed)
    follows = f"{CONTACT_TICKS * TICK_MS} ms for the contact to follow"
    look = contact.count("RELAY_CONTACT_TICKS", CONTACT_TICKS, follows)
    watched = contact.controller.safety.relay_feedback is not None
    return (settle, look) if watched else (settle,)
