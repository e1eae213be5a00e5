"""Shortest times on and off: whole ticks, and too short to trip a rule."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import counted_ticks
from heatwright.spec.controller import Controller
from heatwright.spec.loops import Loop
from heatwright.spec.outputs import Output
from heatwright.spec.quantity import duration


def minimum_times(output: Output | None) -> dict[str, float]:
    """List a digital output's shortest times that are not 0, by their keys."""
    if output is None:
        return {}
    times_s = {"minimum_on": output.stays_on_s, "minimum_off": output.stays_off_s}
    return {key: seconds for key, seconds in times_s.items() if seconds > 0}


def minimum_times_are_ticks(controller: Controller) -> Findings:
    """Find shortest times that are no whole number of ticks, or too long to count."""
    for name, output in controller.outputs.items():
        for key, seconds in minimum_times(output).items():
            yield from counted_ticks(("outputs", name, key), seconds)


def minimum_times_have_a_use(controller: Controller) -> Findings:
    """Find shortest times of outputs that always run."""
    for name, output in controller.outputs.items():
        if output.always_runs:
            for key in minimum_times(output):
                yield Finding(
                    ("outputs", name, key),
                    "an output that always runs is never switched",
                    "Delete it",
                    (("outputs", name, "runs"),),
                )


def minimum_times_leave_the_current_alone(controller: Controller) -> Findings:
    """Find heaters with a measured current that do not follow the algorithm at once.

    Rules `current_while_off` and `no_current` compare the current with what the algorithm asks for.
    """
    for name, loop in controller.loops.items():
        heater = controller.outputs.get(loop.heater)
        if heater is None or heater.current is None:
            continue
        for part in (loop.heater, loop.cooler):
            for key, seconds in minimum_times(controller.outputs.get(str(part))).items():
                yield Finding(
                    ("outputs", str(part), key),
                    f"the heater of the loop {name} can lag behind the algorithm by "
                    f"{duration(seconds)}, and current_while_off or no_current would trip",
                    f"Delete it, or current of {loop.heater}",
                    (("outputs", loop.heater), ("loops", name)),
                )
        fan = controller.outputs.get(str(loop.fan))
        if fan and fan.proof:
            yield Finding(
                ("outputs", str(loop.fan), "proof"),
                f"until the fan's signal comes the heater of the loop {name} stays off, whatever "
                "the algorithm asks for, and no_current would trip",
                f"Delete it, or current of {loop.heater}",
                (("outputs", loop.heater), ("loops", name)),
            )


def minimum_times_break_no_rule(controller: Controller) -> Findings:
    """Check that minimum times are shorter than the times of the rules that count during them."""
    for name, loop in controller.loops.items():
        for part, key, rule, longest_s in _bounds(loop):
            seconds = minimum_times(controller.outputs.get(part)).get(key, 0.0)
            if seconds >= longest_s:
                yield Finding(
                    ("outputs", part, key),
                    f"{duration(seconds)} is not below {'.'.join(rule)} of the loop {name}, "
                    f"{duration(longest_s)}, so a healthy machine would trip it",
                    f"Use less than {duration(longest_s)}",
                    (("loops", name, "protection", *rule), ("loops", name)),
                )


def _bounds(loop: Loop) -> list[tuple[str, str, tuple[str, str], float]]:
    """List an output and its key, then the rule's key and its time, s, which must be longer.

    A heater that is held off, or that waits for a cooler held on, does not heat. A heater held on,
    or a cooler held off, lets the temperature rise.
    """
    rules = loop.protection
    found: list[tuple[str, str, tuple[str, str], float]] = []
    if rules.heating is not None:
        within = (("heating", "within"), rules.heating.within_s)
        found.append((loop.heater, "minimum_off", *within))
        if loop.cooler is not None:
            found.append((loop.cooler, "minimum_on", *within))
    if rules.runaway is not None:
        lasts = (("runaway", "for"), rules.runaway.for_s)
        found.append((loop.heater, "minimum_on", *lasts))
        if loop.cooler is not None:
            found.append((loop.cooler, "minimum_off", *lasts))
    if rules.rising_while_off is not None:
        settle = (("rising_while_off", "settle"), rules.rising_while_off.settle_s)
        found.append((loop.heater, "minimum_on", *settle))
    return found
