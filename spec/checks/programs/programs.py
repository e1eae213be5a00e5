"""Checks of programs: their loop, their operator, their number, their names and targets."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.references import unknown
from heatwright.spec.commands import keyed, nextion_of, programmed, touched
from heatwright.spec.controller import Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import celsius

STORED: Path = ("programs", "stored")


def programs_have_a_loop(controller: Controller) -> Findings:
    """Find programs that name an undefined loop."""
    if controller.programs is not None:
        yield from unknown(
            ("programs", "loop"), controller.programs.loop, "loops", controller.loops
        )


def programs_are_alone(controller: Controller) -> Findings:
    """Refuse a host or a master beside programs: both would set the loop."""
    if controller.programs is None:
        return
    for index, interface in enumerate(controller.interfaces):
        if interface.is_host:
            yield Finding(
                ("interfaces", index, "kind"),
                f"a {interface.kind} interface and programs would both set the setpoint of the "
                "same loop",
                "Delete one of them",
                (("programs",),),
            )


def programs_have_an_operator(controller: Controller) -> Findings:
    """Find programs that nobody could start, and a display that serves another loop."""
    programs = controller.programs
    if programs is None or programs.loop not in controller.loops:
        return
    display = nextion_of(controller)
    if display is not None and display.loop != programs.loop:
        yield Finding(
            ("interfaces", controller.interfaces.index(display), "loop"),
            f"the display must serve the loop of the programs, {programs.loop}",
            f"Write loop: {programs.loop}",
            (("programs", "loop"),),
        )
    elif not has_an_operator(controller, programs.loop):
        yield Finding(
            ("programs", "loop"),
            f"nobody could start a program: no display and no keys serve the loop {programs.loop}",
            f"Add {{kind: nextion, loop: {programs.loop}}} or {{kind: lcd_keypad, loop: "
            f"{programs.loop}}} to interfaces",
            (("interfaces",),),
        )


def has_an_operator(controller: Controller, loop_name: str) -> bool:
    """Return whether an operator has a menu for a loop: a touch display, or keypad and programs."""
    by_keys = keyed(controller, loop_name) and programmed(controller, loop_name)
    return by_keys or touched(controller, loop_name)


def programs_have_room(controller: Controller) -> Findings:
    """Find more programs than `places`, and programs with more segments than `points`."""
    programs = controller.programs
    if programs is None:
        return
    if len(programs.stored) > programs.places:
        yield Finding(
            STORED,
            f"there are {len(programs.stored)} programs for {programs.places} places",
            f"Write places: {len(programs.stored)}, or delete some",
            (("programs", "places"),),
        )
    for index, program in enumerate(programs.stored):
        if len(program.segments) > programs.points:
            yield Finding(
                (*STORED, index, "segments"),
                f"this program has {len(program.segments)} segments, and the key points allows "
                f"only {programs.points}",
                f"Join some, or write points: {len(program.segments)}",
                (("programs", "points"),),
            )


def programs_names_apart(controller: Controller) -> Findings:
    """Find programs with the same name."""
    first: dict[str, int] = {}
    for index, program in enumerate(controller.programs.stored if controller.programs else ()):
        if first.setdefault(program.name, index) != index:
            yield Finding(
                (*STORED, index, "name"),
                f"program {first[program.name] + 1} is called {program.name} too",
                "Use another name",
                ((*STORED, first[program.name], "name"),),
            )


def what_a_fault_keeps_can_go_on(controller: Controller) -> Findings:
    """Find programs that are kept after a fault, but can never be resumed."""
    programs = controller.programs
    if programs is None or programs.on_fault == "stop":
        return
    after = programs.after_power_loss
    if after.resume_within_k == 0 and after.otherwise == "stop":
        yield Finding(
            ("programs", "on_fault"),
            "after a fault a program resumes as after_power_loss allows, and it never allows it",
            "Write after_power_loss: {resume_within: 30 K, otherwise: stop}, or on_fault: stop",
            (("programs", "after_power_loss"),),
        )


def targets_can_be_chosen(controller: Controller) -> Findings:
    """Check that the targets are within the range of setpoints."""
    programs = controller.programs
    loop = None if programs is None else controller.loops.get(programs.loop)
    if programs is None or loop is None:
        return
    low_c, high_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
    for index, program in enumerate(programs.stored):
        for place, segment in enumerate(program.segments):
            if segment.to_c is not None and not low_c <= segment.to_c <= high_c:
                yield Finding(
                    (*STORED, index, "segments", place, "to"),
                    f"{celsius(segment.to_c)} is outside the range of setpoints",
                    f"Use {celsius(low_c)} to {celsius(high_c)}",
                    (("loops", programs.loop, "setpoint"),),
                )


def slopes_have_a_program(controller: Controller) -> Findings:
    """Find a feed-forward in loops without programs: only a program's setpoint has a slope."""
    if any(True for _ in programs_have_a_loop(controller)):
        return
    for name, loop in controller.loops.items():
        if getattr(loop.algorithm, "feed_forward", 0.0) and not programmed(controller, name):
            yield Finding(
                ("loops", name, "algorithm", "feed_forward"),
                "it uses the slope of a program's setpoint, and no program sets this loop",
                "Delete it, or add programs",
                (("programs",),),
            )
