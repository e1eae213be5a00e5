"""Keypads: steps that fit the range of setpoints; countdowns that can be set and always end."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import placed, programmed, starts_enabled, switched
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import LcdKeypad
from heatwright.spec.problems import Path
from heatwright.spec.quantity import duration, number

MINUTE_S = 60.0


def step_fits_range(controller: Controller) -> Findings:
    """Find steps of the keypad larger than the setpoint's range, or finer than the display."""
    for index, interface in placed(controller, LcdKeypad).items():
        path = ("interfaces", index, "step")
        loop = controller.loops.get(interface.loop)
        if round(interface.step_k, 1) != interface.step_k:
            yield Finding(
                path,
                f"{number(interface.step_k)} K is finer than the display, which shows 0.1 °C",
                f"Use {number(round(interface.step_k, 1))} K",
            )
        elif loop is not None:
            range_k = round(loop.setpoint.maximum_c - loop.setpoint.minimum_c, 6)
            if interface.step_k > range_k:
                yield Finding(
                    path,
                    f"a step of {number(interface.step_k)} K is more than the whole range of "
                    f"setpoints, {number(range_k)} K",
                    f"Use at most {number(range_k)} K",
                    (("loops", interface.loop, "setpoint"),),
                )


def countdowns_have_a_use(controller: Controller) -> Findings:
    """Find countdowns that programs or hosts replace, power cuts lose, or that may never start."""
    for index, interface in placed(controller, LcdKeypad).items():
        if interface.countdown is None:
            continue
        path: Path = ("interfaces", index, "countdown")
        name = interface.loop
        if name not in controller.loops:
            continue
        if programmed(controller, name):
            yield Finding(
                path,
                f"programs set the setpoint of loop {name}, and a program has its own times",
                "Delete it, and end a program with a hold",
                (("programs",),),
            )
        elif not switched(controller, name):
            yield Finding(
                path,
                f"a gcode interface serves the loop {name}, and its host ends the heating",
                "Delete it",
                (("interfaces",),),
            )
        elif starts_enabled(controller, name):
            yield Finding(
                path,
                "a power cut loses the countdown, and the loop would then heat without end",
                f"Delete it, or delete starts: enabled of the loop {name}",
                (("loops", name, "starts"),),
            )
        elif interface.countdown.counts == "from setpoint" and controller.loops[name].settles_below:
            yield Finding(
                (*path, "counts"),
                "without ki the loop may settle below its setpoint, and the countdown never start",
                "Write counts: at once, or give the algorithm a ki",
                (("loops", name, "algorithm"),),
            )


def countdowns_count_minutes(controller: Controller) -> Findings:
    """Find times that are no whole minutes, and steps that are too long or too short."""
    for index, interface in placed(controller, LcdKeypad).items():
        if interface.countdown is None:
            continue
        path: Path = ("interfaces", index, "countdown")
        countdown, loop = interface.countdown, controller.loops.get(interface.loop)
        odd = False
        for key, seconds in (("longest", countdown.longest_s), ("step", countdown.step_s)):
            if seconds % MINUTE_S:
                odd = True
                yield Finding(
                    (*path, key),
                    f"{duration(seconds)} is no whole number of minutes, which the display shows",
                    f"Use {duration(MINUTE_S * round(seconds / MINUTE_S))}",
                )
        if odd:
            continue
        if countdown.step_s > countdown.longest_s:
            yield Finding(
                (*path, "step"),
                f"a step of {duration(countdown.step_s)} is more than the longest time, "
                f"{duration(countdown.longest_s)}",
                f"Use at most {duration(countdown.longest_s)}",
                ((*path, "longest"),),
            )
        elif loop is not None and countdown.step_s < loop.period_s:
            yield Finding(
                (*path, "step"),
                f"a step of {duration(countdown.step_s)} is less than the loop's period, "
                f"{loop.told_period}",
                f"Use at least {duration(MINUTE_S * -(-loop.period_s // MINUTE_S))}",
                (("loops", interface.loop, "period"),),
            )
