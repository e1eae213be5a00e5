"""Faults that may occur at any moment of a campaign's run."""

from collections.abc import Callable

from heatwright.sim.faults import effects
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.fault import Act
from heatwright.sim.faults.machine_parts.heaters import WEAK_SHARE
from heatwright.sim.faults.site import Place
from heatwright.sim.faults.world import World
from heatwright.sim.machine import Heat
from heatwright.sim.native.pins import Level
from heatwright.spec import Controller

LEAKING_SHARE = 0.3
"""Share of full power that a damaged switch passes while it is off."""


def _switch(heat: Heat) -> Act:
    def act(world: World) -> None:
        world.wiring.heat[world.site.loop.heater] = heat

    return act


def _stand(world: World) -> None:
    """Hold the tip at its present temperature permanently."""
    stood_c = world.sensed_c
    world.wiring.feel[world.site.loop.sensor] = lambda _: stood_c


def _fall_out(world: World) -> None:
    lag_s = world.site.network.sense[world.site.loop.sensor].lag_s
    world.wiring.feel[world.site.loop.sensor] = effects.fallen_out(world, lag_s)


def _stop_fan(world: World) -> None:
    """Force the line of the loop's fan to off."""
    fan = world.site.controller.on_off_output(world.site.loop.fan or "")
    off: Level = "low" if fan.active == "high" else "high"
    world.device.avr.pins.drive(world.site.controller.board.pins[fan.pin].port_name, off)


def _stall_fan(world: World) -> None:
    """Stop the loop's fan, whatever its line's level."""
    world.device.proofs[world.site.loop.fan or ""].fail(stands=True)


def _always(place: Place) -> bool:
    del place
    return True


def _has_fan(place: Place) -> bool:
    return place.loop.fan is not None


def _proves_fan(place: Place) -> bool:
    fan = place.controller.outputs.get(place.loop.fan or "")
    return fan is not None and fan.proof is not None


BREAKS: dict[str, tuple[Act, Callable[[Place], bool]]] = {
    "heater_open": (_switch(effects.OPENED), _always),
    "heater_weak": (_switch(effects.weakened(WEAK_SHARE)), _always),
    "switch_shorted": (_switch(effects.SHORTED), _always),
    "switch_leaking": (_switch(effects.leaking(LEAKING_SHARE)), _always),
    "sensor_cut": (memory.cut_line, _always),
    "sensor_fallen_out": (_fall_out, _always),
    "sensor_stands": (_stand, _always),
    "fan_line_cut": (_stop_fan, _has_fan),
    "fan_stalled": (_stall_fan, _proves_fan),
}
"""By name: the act that breaks a part of a loop, and the test whether a loop has that part."""


def applicable(controller: Controller, name: str) -> list[str]:
    """Return the loops on which this fault is possible."""
    return [loop for loop in controller.loops if BREAKS[name][1](Place(controller, loop))]
