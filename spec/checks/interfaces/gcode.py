"""G-code hosts: the loops, fans and steppers that they command, and the lines that they send."""

import re

from heatwright.spec.checks.finding import Finding, Findings, scenario_events, untaken
from heatwright.spec.checks.references import driven_by_loops, unknown
from heatwright.spec.commands import countdown_of, gcode_of, modbus_of, nextion_of, placed
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Gcode
from heatwright.spec.problems import Path

HEATS = re.compile(r"M(104|109|140|190|141|191)\b(?:.*\b(T\d+))?")
"""A line that sets a temperature, and the tool that it may name."""
OWN = {"140": "B", "190": "B", "141": "C", "191": "C"}
"""Names of the bed (B) and chamber (C), by the commands that set them."""
LONGEST_HOST_LINE = 80
"""Maximum length of a line that a host sends; the firmware's own limit is above it."""


def host_names_once(controller: Controller) -> Findings:
    """Find loops and fans that a host would call by two names."""
    for index, interface in placed(controller, Gcode).items():
        for section in ("loops", "fans"):
            first: dict[str, str] = {}
            for address, name in getattr(interface, section).items():
                if first.setdefault(name, address) != address:
                    yield Finding(
                        ("interfaces", index, section, address),
                        f"at the host {name} already has the name {first[name]}",
                        "Delete one of them",
                        (("interfaces", index, section, first[name]),),
                    )


def host_fans(controller: Controller) -> Findings:
    """Find fans of a host that are no outputs, or that something else switches."""
    for index, interface in placed(controller, Gcode).items():
        for address, name in interface.fans.items():
            path = ("interfaces", index, "fans", address)
            yield from unknown(path, name, "outputs", controller.outputs)
            yield from _fan(controller, path, name)


def _fan(controller: Controller, path: Path, name: str) -> Findings:
    output = controller.outputs.get(name)
    because_of: tuple[Path, ...] = (("outputs", name), ("loops",))
    if output is None:
        return
    if output.feeds or output.is_windowed:
        yield Finding(
            path,
            f"{name} is of the kind {output.kind}, and a host switches fans on and off or sets "
            "their speed",
            "Name a digital or a pwm output",
            because_of,
        )
    elif name in driven_by_loops(controller):
        yield Finding(
            path,
            f"a loop already switches {name}, or relies on it",
            "Name another output",
            because_of,
        )
    elif output.always_runs:
        yield Finding(
            ("outputs", name, "runs"),
            "a fan that always runs cannot be switched by a host",
            "Delete runs, or remove the fan from the interface",
            (path,),
        )


def host_steppers(controller: Controller) -> Findings:
    """Find steppers of a host that are no outputs, or outputs that cannot feed material."""
    for index, interface in placed(controller, Gcode).items():
        for address, name in interface.steppers.items():
            path = ("interfaces", index, "steppers", address)
            yield from unknown(path, name, "outputs", controller.outputs)
            output = controller.outputs.get(name)
            if output is not None and not output.feeds:
                yield Finding(
                    path,
                    f"{name} is of the kind {output.kind}, which cannot feed material",
                    "Name a stepper",
                    (("outputs", name),),
                )


def steppers_wait(controller: Controller) -> Findings:
    """Find steppers for which no loop says when it is ready: cold material must not be fed."""
    waits = any(
        loop.ready_within_k is not None and name in host_loops(controller)
        for name, loop in controller.loops.items()
    )
    for name in controller.steppers:
        if not waits:
            yield Finding(
                ("outputs", name),
                "no loop of a gcode interface has ready_within, so the stepper could feed cold "
                "material",
                "Add ready_within:, such as 2 K, to the loop that melts the material",
                (("loops",), ("interfaces",)),
            )


def ready_is_asked_for(controller: Controller) -> Findings:
    """Find loops with a `ready_within` that nothing waits for."""
    for name, loop in controller.loops.items():
        asked = modbus_of(controller) is not None or name in host_loops(controller)
        countdown = countdown_of(controller, name)
        asked = asked or (countdown is not None and countdown.counts == "from setpoint")
        if loop.ready_within_k is not None and not asked:
            yield Finding(
                ("loops", name, "ready_within"),
                "nobody waits for this loop: no gcode or modbus_rtu interface serves it",
                "Delete it, or name the loop in a gcode interface",
                (("interfaces",),),
            )


def host_loops(controller: Controller) -> set[str]:
    """List the loops that a host commands."""
    gcode = gcode_of(controller)
    return set() if gcode is None else set(gcode.loops.values())


def lines_fit_the_host(controller: Controller) -> Findings:
    """Find lines of the scenario that are too long for a host."""
    if gcode_of(controller) is None:
        return
    for path, event in scenario_events(controller):
        if event.send is not None and len(event.send) > LONGEST_HOST_LINE:
            yield Finding(
                (*path, "send"),
                f"a line from a host has at most {LONGEST_HOST_LINE} characters",
                "Shorten it",
                (("interfaces",),),
            )


def lines_name_served_loops(controller: Controller) -> Findings:
    """Find lines of the scenario that heat a loop which the host does not command."""
    gcode = gcode_of(controller)
    if gcode is None:
        return
    for path, event in scenario_events(controller):
        found = HEATS.match((event.send or "").upper())
        called = found and (OWN.get(found[1]) or found[2])
        if called and called not in gcode.loops:
            yield Finding(
                (*path, "send"),
                f"this host commands no loop {called}, so the line would do nothing",
                f"Use {', '.join(gcode.loops)}, or add {called} to the loops of the host",
                (("interfaces",),),
            )


def lines_have_a_host(controller: Controller) -> Findings:
    """Find lines of the scenario that no interface would read."""
    if gcode_of(controller) is None and nextion_of(controller) is None:
        remedy = (
            "Add {kind: gcode, loops: {T0: …}} or {kind: nextion, loop: …} to interfaces, or "
            "delete the event"
        )
        reason = "no interface reads lines"
        yield from untaken(controller, "send", "send", reason, remedy, ("interfaces",))
