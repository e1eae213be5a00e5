"""LEDs: each shows one loop, and a state that this loop can have."""

from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.commands import modbus_of, placed, shown_loop
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Indicators
from heatwright.spec.problems import Path


def leds_show_one_loop(controller: Controller) -> Findings:
    """Find indicators that name none of several loops, and loops with two sets of them."""
    first: dict[str, int] = {}
    for index, interface in placed(controller, Indicators).items():
        path: Path = ("interfaces", index)
        if interface.loop is None and len(controller.loops) > 1:
            yield Finding(
                path,
                "this interface names no loop, and the controller has several",
                f"Add loop:, such as loop: {next(iter(controller.loops))}",
                (("loops",),),
            )
            continue
        name = shown_loop(controller, interface)
        if first.setdefault(name, index) != index:
            yield Finding(
                (*path, "leds"),
                f"interfaces[{first[name]}] already shows the loop {name}",
                "Put all LEDs of the loop there",
                (("interfaces", first[name]), ("loops",)),
            )


def leds_have_a_meaning(controller: Controller) -> Findings:
    """Find LEDs that would never light."""
    for index, interface in placed(controller, Indicators).items():
        loop = controller.loops.get(shown_loop(controller, interface))
        for pin, meaning in interface.leds.items():
            path: Path = ("interfaces", index, "leds", pin)
            if meaning == "cooling" and loop is not None and loop.cooler is None:
                yield Finding(
                    path,
                    "the loop has no cooler, so this LED would never light",
                    "Delete it",
                    (("loops",), ("interfaces", index, "loop")),
                )
            elif meaning == "communicating" and modbus_of(controller) is None:
                yield Finding(
                    path,
                    "there is no modbus_rtu interface, so this LED would never light",
                    "Delete it, or add {kind: modbus_rtu} to interfaces",
                    (("interfaces",),),
                )
