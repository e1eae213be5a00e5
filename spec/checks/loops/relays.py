"""The safety relay: an output of its own, and a contact that shows whether it is open."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.minimum_times import minimum_times
from heatwright.spec.checks.references import driven_by_host, driven_by_loops
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path

RELAY: Path = ("safety", "relay")


def relay_is_free(controller: Controller) -> Findings:
    """Find a safety relay that is no digital output, or that something else switches."""
    relay = controller.safety.relay
    output = None if relay is None else controller.outputs.get(relay)
    if relay is None or output is None:
        return
    because_of: tuple[Path, ...] = (("outputs", relay), ("loops",), ("interfaces",))
    if not output.is_on_off:
        yield Finding(
            RELAY,
            f"{relay} is of the kind {output.kind}, and a relay is only on or off",
            "Name a digital output",
            because_of,
        )
    elif relay in driven_by_loops(controller) | driven_by_host(controller):
        yield Finding(
            RELAY,
            f"a loop or a host also switches {relay}: the relay could not cut the heater's supply",
            "Give the relay an output of its own",
            because_of,
        )


def relay_can_open(controller: Controller) -> Findings:
    """Find keys of the relay's output that would keep it from opening at once."""
    relay = controller.safety.relay
    output = None if relay is None else controller.outputs.get(relay)
    if relay is None or output is None or not output.is_on_off:
        return
    path: Path = ("outputs", relay)
    if output.always_runs:
        yield Finding(
            (*path, "runs"),
            "a safety relay that is always closed cannot cut the supply",
            "Delete runs",
            (RELAY,),
        )
    for key in minimum_times(output):
        yield Finding(
            (*path, key),
            "the safety relay must open at once, and close as soon as heat is wanted",
            "Delete it",
            (RELAY,),
        )


def feedback_has_a_relay(controller: Controller) -> Findings:
    """Find a feedback contact without a safety relay."""
    safety = controller.safety
    if safety.relay_feedback is not None and safety.relay is None:
        yield Finding(
            ("safety", "relay_feedback"),
            "there is no safety relay to which this contact could belong",
            "Add relay: with the name of its output, or delete relay_feedback",
        )
