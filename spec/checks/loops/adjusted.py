"""Numbers of the keypad: they exist, fit the display, and pass every check at their extremes."""

from collections.abc import Iterator

from heatwright.spec.adjusted import (
    COLUMNS,
    GAINS,
    KINDS,
    MOST_DECIMALS,
    Number,
    Setting,
    numbers_of,
    words,
)
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import keypad_of, programmed, tunable
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Adjust
from heatwright.spec.loading.suggest import listed
from heatwright.spec.problems import Path

MOST_STEPS = 1000
"""Maximum number of steps: more are too many to press, and too fine for single precision."""


def numbers_have_a_use(controller: Controller) -> Findings:
    """Find numbers that the algorithm does not have, or that another interface sets."""
    for path, name, adjust in _places(controller):
        kind = controller.loops[name].algorithm.kind
        if programmed(controller, name):
            yield Finding(
                path,
                f"programs set the setpoint of loop {name}; their menu already sets its numbers",
                "Delete it",
                (("programs",),),
            )
            continue
        fields = type(controller.loops[name].algorithm).model_fields
        for each in KINDS:
            if getattr(adjust, each.key) is None:
                continue
            if each.field not in fields:
                yield Finding(
                    (*path, each.key),
                    f"{kind} has no {each.key}",
                    "Delete it",
                    (("loops", name, "algorithm"),),
                )
            elif each.key in GAINS and tunable(controller, name):
                yield Finding(
                    (*path, each.key),
                    f"keys cannot set the gains of the loop {name}: its host, master or touch "
                    "display does",
                    "Delete it",
                    (("interfaces",),),
                )
        if not any(getattr(adjust, each.key) for each in KINDS):
            able = [each.key for each in KINDS if each.field in fields]
            yield Finding(path, "no number is named", f"Add {listed(able)}, or delete adjust")


def numbers_in_range(controller: Controller) -> Findings:
    """Check that minimum ≤ number ≤ maximum, and that keypad and display can handle the steps."""
    for path, name, _ in _places(controller):
        for each in numbers_of(controller, name):
            at: Path = (*path, each.kind.key)
            own: Path = ("loops", name, "algorithm", each.kind.key)
            if each.minimum >= each.maximum:
                yield Finding(
                    (*at, "minimum"),
                    f"{each.said(each.minimum)} is not below the maximum of "
                    f"{each.said(each.maximum)}",
                    "Use a lower minimum",
                    ((*at, "maximum"),),
                )
            elif not each.minimum <= each.value <= each.maximum:
                yield Finding(
                    at,
                    f"the algorithm's {each.words(each.value)} is not in this range",
                    f"Widen the range, or change {each.kind.key} of the loop {name}",
                    (own,),
                )
            else:
                yield from _steps(at, each, own)


def _steps(at: Path, each: Number, own: Path) -> Findings:
    range_of = round(each.maximum - each.minimum, 6)
    if each.step > range_of:
        yield Finding(
            (*at, "step"),
            f"a step of {each.said(each.step)} is more than the whole range of "
            f"{each.said(range_of)}",
            f"Use at most {each.said(range_of)}",
            (at,),
        )
    elif each.maximum > MOST_STEPS * each.step:
        least = each.said(each.maximum / MOST_STEPS)
        yield Finding(
            (*at, "step"),
            f"{each.said(each.step)} is less than a thousandth of {each.said(each.maximum)}",
            f"Use at least {least}",
            (at,),
        )
    elif each.decimals > MOST_DECIMALS or _columns(each) > COLUMNS:
        yield Finding(
            at,
            f"{each.kind.key} with {each.decimals} decimals does not fit into the display's line "
            f"of {COLUMNS} characters",
            f"Use fewer digits in minimum, maximum, step and in the algorithm's {each.kind.key}",
            (own,),
        )


def of_extreme(controller: Controller, finding: Finding, setting: Setting) -> Finding:
    """Add to a finding the setting that causes it, and point it to that end of the range."""
    (place, _, _), *_ = _places(controller)
    keypad = keypad_of(controller)
    assert keypad is not None  # noqa: S101 - only a keypad has settings
    path = finding.path
    for each, value in setting:
        if path == ("loops", keypad.loop, "algorithm", each.kind.key):
            path = (*place, each.kind.key, "minimum" if value == each.minimum else "maximum")
    return Finding(
        path,
        f"with {words(setting)}, as keys may set it, {finding.reason}",
        finding.remedy,
        (*finding.because_of, finding.path, place),
    )


def _places(controller: Controller) -> Iterator[tuple[Path, str, Adjust]]:
    """Yield the path of a keypad's `adjust`, the name of its loop, and its numbers."""
    keypad = keypad_of(controller)
    if keypad is None or keypad.adjust is None or keypad.loop not in controller.loops:
        return
    yield ("interfaces", controller.interfaces.index(keypad), "adjust"), keypad.loop, keypad.adjust


def _columns(each: Number) -> int:
    shown = f"{each.maximum:.{each.decimals}f}"
    return len(f"{each.kind.title}{shown}{each.kind.shown_unit}")
