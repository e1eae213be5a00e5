"""`on_for_at_most`: an operator can switch on again; rules, countdowns and programs end earlier."""

from collections.abc import Iterator
from operator import itemgetter

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import countable, time_outs
from heatwright.spec.commands import commanded, countdown_of, programmed, starts_enabled, switched
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration


def on_times_have_a_beginning(controller: Controller) -> Findings:
    """Refuse `on_for_at_most` of a loop that nobody switches on, or that a reset switches on."""
    for name, loop in controller.loops.items():
        if loop.protection.on_for_at_most_s is None:
            continue
        path: Path = ("loops", name, "protection", "on_for_at_most")
        if not commanded(controller, name):
            yield Finding(
                path,
                "nobody could acknowledge the fault and switch the loop on again: no interface "
                "serves the loop",
                "Delete it, or add an interface with an operator",
                (("interfaces",),),
            )
        elif kept_off := _kept_off(controller, name):
            yield Finding(
                path,
                "after a power cut the loop would be on without an operator, and the time for "
                "which it was on is lost",
                f"Delete it, or write {kept_off} in the loop {name}",
                (("loops", name),),
            )


def _kept_off(controller: Controller, name: str) -> str:
    """Return the entry that would keep a loop off after a reset; empty if the loop is off."""
    setpoint = controller.loops[name].setpoint
    if switched(controller, name):
        return "starts: disabled" if starts_enabled(controller, name) else ""
    if setpoint.initial_c != 0:
        return "setpoint.initial: 0 °C"
    return "setpoint.stored: false" if setpoint.stored else ""


def on_times_end_last(controller: Controller) -> Findings:
    """Find an `on_for_at_most` that ends before a rule's time, a countdown or a program does."""
    for name, loop in countable(controller):
        most_s = loop.protection.on_for_at_most_s
        if most_s is None:
            continue
        what, path, longest_s = max(_others(controller, name, loop), key=itemgetter(2))
        if longest_s >= most_s:
            yield Finding(
                ("loops", name, "protection", "on_for_at_most"),
                f"{duration(most_s)} is not longer than {what}, which takes {duration(longest_s)}",
                f"Use more than {duration(longest_s)}",
                (path,),
            )


def _others(controller: Controller, name: str, loop: Loop) -> Iterator[tuple[str, Path, float]]:
    """List rules, countdowns and programs of the loop that end by time: name, path, duration, s."""
    rules, protection = ("protection",), loop.protection
    others = time_outs(loop) | {
        (*rules, "stale_after"): protection.stale_after_s,
        (*rules, "master_lost_after"): protection.master_lost_after_s or 0.0,
    }
    for inner, seconds in others.items():
        yield ".".join(map(str, inner)), ("loops", name, *inner), seconds
    countdown = countdown_of(controller, name)
    if countdown is not None:
        yield "the longest countdown", ("interfaces",), countdown.longest_s
    programs = controller.programs
    if programs is None or not programmed(controller, name):
        return
    if programs.hold_back is not None:
        yield "hold_back.limit", ("programs", "hold_back", "limit"), programs.hold_back.limit_s
    for index, program in enumerate(programs.stored):
        times_s = sum(each.over_s or each.hold_s or 0.0 for each in program.segments)
        yield f"the program {program.name}", ("programs", "stored", index), times_s
