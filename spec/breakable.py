"""Which rules can trip in a controller: its display needs a page for each."""

from collections.abc import Iterator

from heatwright.spec.commands import gcode_of
from heatwright.spec.controller import Controller
from heatwright.spec.monitors import tripping
from heatwright.spec.proofs import proofs
from heatwright.spec.rules import RULES, Rule
from heatwright.spec.self_checks import self_check_rules

_OF_ALL = (1, 2, 3, 4, 5, 6, 7, 8, 14, 15, 16, 29)
"""Codes of the rules on limits and processor, which can trip in every controller, and of the rules
on sensors that every firmware names."""

_OF_LOOPS = {
    "frozen": (9,),
    "heating": (10,),
    "runaway": (11,),
    "rising_while_off": (13,),
    "master_lost_after_s": (23,),
    "on_for_at_most_s": (30,),
}
"""Codes of rules by the key of `protection` that may be off."""


def rules_of(controller: Controller) -> tuple[Rule, ...]:
    """List the rules that can trip, in the order of their codes."""
    found = {*_OF_ALL, *_by_loops(controller), *_by_parts(controller)}
    checks = self_check_rules(controller)
    found |= {code for code, rule in RULES.items() if rule.id in checks}
    return tuple(RULES[code] for code in sorted(found))


def _by_loops(controller: Controller) -> Iterator[int]:
    for loop in controller.loops.values():
        for key, codes in _OF_LOOPS.items():
            if getattr(loop.protection, key) is not None:
                yield from codes
        runaway = loop.protection.runaway
        if runaway is not None and runaway.below_k is not None:
            yield 12
        effort = loop.protection.effort
        if effort is not None and effort.high_percent is not None:
            yield 33
        if effort is not None and effort.low_percent is not None:
            yield 34


def _by_parts(controller: Controller) -> Iterator[int]:
    for sensor in controller.sensors.values():
        yield from sensor.rules
    if gcode_of(controller) is not None:
        yield 19
    if controller.programs is not None and controller.programs.hold_back is not None:
        yield 24
    if controller.safety.relay_feedback is not None:
        yield from (25, 26)
    if controller.monitors:
        yield 27
    if proofs(controller):
        yield 28
    if tripping(controller):
        yield 31
    if any(loop.also for loop in controller.loops.values()):
        yield 32
