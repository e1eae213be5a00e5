"""Limits of protections that follow from the plant, where the spec leaves them open."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from heatwright.spec.base import ReadOnlyDict
from heatwright.spec.heated_loop import TIMES, HeatedLoop
from heatwright.spec.loops import Frozen, Loop
from heatwright.spec.quantity import about, celsius, duration, number

if TYPE_CHECKING:
    from heatwright.spec.controller import Controller


LOSSES = 1.5
"""So many times its plant's losses may a machine have: resistances 30 % smaller, and 5 % of power
that the supply does not give."""

BEHIND = 1.5
"""At full power a heater that is dead is told before a sensor: it is as probable, and `heating`
sees both. So many times its time is enough for the duty to grow to full power."""


class Derived(NamedTuple):
    """A rule's numbers that were derived and, for each, how."""

    values: dict[str, float]
    words: dict[str, str]


_KNOWN: dict[str, Derived] = {}
"""By all that it depends on: to follow a plant takes a while."""


def with_derived(controller: Controller) -> Controller:
    """Put numbers in where the spec leaves a rule of a loop open and the plant says more."""
    loops = {name: _with_derived(controller, name, loop) for name, loop in controller.loops.items()}
    if all(loops[name] is loop for name, loop in controller.loops.items()):
        return controller
    return controller.model_copy(update={"loops": ReadOnlyDict(loops)})


def _with_derived(controller: Controller, name: str, loop: Loop) -> Loop:
    rule, simulation = loop.protection.frozen, controller.simulation
    if rule is None or simulation is None:
        return loop
    open_keys = {
        key
        for key, alias in (("for_s", "for"), ("holding_percent", "holding"))
        if key not in rule.model_fields_set or alias in rule.derived
    }
    key = repr((simulation, controller.outputs, controller.sensors, loop, sorted(open_keys)))
    if open_keys and key not in _KNOWN:
        try:
            heated = HeatedLoop(controller, name, simulation)
            _KNOWN[key] = _frozen(heated, rule, open_keys)
        except (ArithmeticError, AssertionError, LookupError, ValueError):
            _KNOWN[key] = Derived({}, {})  # the checks tell what is wrong with such a plant
    values, words = _KNOWN.get(key, Derived({}, {}))
    if not values:
        return loop
    frozen = rule.model_copy(update=values).derived_as(words)
    protection = loop.protection.model_copy(update={"frozen": frozen})
    return loop.model_copy(update={"protection": protection})


def _frozen(heated: HeatedLoop, rule: Frozen, open_keys: set[str]) -> Derived:
    """Derive the duty that holding may need, and the time in which more than that must show.

    Less than this plant takes on a cold day would trip in health. From there on, the more the
    better for a machine that loses more than its plant; but no more than all nodes bear for ever,
    for nobody sees it while the reading stands still, and so much less than full power that there
    is something left to count.

    The time is as long as without a plant, so that a machine that loses more does not trip where it
    rests; but no longer than full power may go on, and what a healthy machine needs in any case.
    """
    values: dict[str, float] = {}
    words: dict[str, str] = {}
    percent = rule.holding_percent
    if "holding_percent" in open_keys:
        held = f"what {celsius(heated.highest_c)} takes on a cold day"
        needed_w = min(heated.most_hold_w(), (heated.hold_w + heated.full_w) / 2)
        borne_w = heated.borne_w()
        choices = [
            (LOSSES * needed_w, f"{number(LOSSES)} times {held}"),
            (borne_w, "what all nodes bear for ever") if borne_w > needed_w else (needed_w, held),
            ((needed_w + heated.full_w) / 2, f"half way from {held} to full power"),
        ]
        least_w, words["holding"] = min(choices)
        values["holding_percent"] = percent = math.ceil(1000 * least_w / heated.power_w) / 10
    power_w = min(heated.power_w * percent / 100, heated.full_w)
    if "for_s" in open_keys and power_w > heated.hold_w:
        still_s = heated.longest_still_s(power_w)
        least_s = TIMES * still_s + heated.late_s
        heating = heated.loop.protection.heating
        first_s = BEHIND * heating.within_s if heating is not None else 0.0
        usual_s = float(Frozen.model_fields["for_s"].default)
        borne_s = heated.borne_s(usual_s)
        for_s, words["for"] = max(
            (borne_s, "so long all nodes bear full power" if borne_s < usual_s else "as usual"),
            (first_s, f"{number(BEHIND)} times what heating has, which knows full power better"),
            (
                least_s,
                f"at that duty a reading stands still for up to {about(still_s)} s; "
                f"{number(TIMES)} times that, and {duration(round(heated.late_s, 3))} for delays",
            ),
        )
        values["for_s"] = heated.rounded_s(for_s)
    return Derived(values, words)
