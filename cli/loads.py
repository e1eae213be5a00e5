"""The current that the supply and the switch of a load must carry, at its peak and in the mean."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from heatwright.spec import Controller

WHOLE_SHARE = 1.0
"""Share of the time in which a load conducts at full duty, if it is rated for its supply."""


def loads(controller: Controller) -> Iterator[dict[str, Any]]:
    """Yield the currents of each pulsed load that is measured, or rated for less than its supply.

    Each has `output`, `peak_a` while it is on, `rms_a` and `mean_a` at full duty, and the powers
    `full_w` at full duty and `dead_w` if the switch fails and conducts permanently. A load without
    power or supply is left out.
    """
    from heatwright.spec import full_a  # noqa: PLC0415

    for name, output in controller.switches.items():
        if output.is_on_off or output.power_w is None:
            continue
        peak_a = full_a(output)
        if peak_a is None or (output.full_share == WHOLE_SHARE and output.current is None):
            continue
        yield {
            "output": name,
            "peak_a": peak_a,
            "rms_a": peak_a * output.mean_of_rms,
            "mean_a": peak_a * output.full_share,
            "full_w": output.power_w,
            "dead_w": output.power_w / output.full_share,
        }


def told(load: dict[str, Any]) -> str:
    """Return a load's currents as a line of text."""
    return (
        f"{load['output']}: supply and switch carry {load['peak_a']:.3g} A while it is on; at full "
        f"duty that is {load['rms_a']:.3g} A rms, {load['mean_a']:.3g} A in the mean, "
        f"{load['full_w']:.3g} W; a switch that fails closed gives {load['dead_w']:.3g} W."
    )
