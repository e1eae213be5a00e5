"""Keys: steps that fit the range."""

from __future__ import annotations

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import LcdKeypad
from heatwright.spec.quantity import number


def step_fits_range(controller: Controller) -> Findings:
    """Find steps of the keypad larger than the setpoint's range, or finer than the display."""
    for index, interface in enumerate(controller.interfaces):
        if not isinstance(interface, LcdKeypad):
            continue
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
