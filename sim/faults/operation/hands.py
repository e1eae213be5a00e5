"""The loop's operator: sets its setpoint, switches it and acknowledges faults, by any interface."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from heatwright.sim.scenario import PRESS_S
from heatwright.spec import facts_of
from heatwright.spec.adjusted import KINDS

if TYPE_CHECKING:
    from heatwright.sim.faults.site import Site
    from heatwright.sim.faults.world import World

TOUCH_S = 0.1
"""Time until the firmware knows of a touch: the display's line and a tick."""
REST_S = 1.1
"""Longer than all keys must be released before SELECT acknowledges."""
HOLDS = 1.2
"""Factor by which a person holds SELECT longer than needed."""
HELD_S = 2.6
"""A key held this long changes to coarse steps: half a second, and twenty repeats."""
COARSE_STEPS = 10
LONGEST_HOLD_S = 60.0
PAGES = 1 + len(KINDS)
"""Maximum number of pages after the setpoint's: the timer's, and one for each kind of number."""
OFF = ("OFF, UP: ", "Done UP: ")
"""Start of the display's second line if the loop was switched off by a key or by the timer."""
SETPOINT = ("Set temp ", *OFF)
"""Start of the display's second line while it shows the setpoint."""


def release(world: World) -> None:
    """Acknowledge a locked-out fault, as a person at the machine does.

    Raises LookupError: the controller has no lock-out.
    """
    lockout = world.site.controller.lockout
    if lockout is None:
        raise LookupError("This controller has no lock-out.")
    if world.site.has_keys:
        hold_select(world, HOLDS * lockout.hold_s)
        return
    world.power_cut()
    world.run(lockout.wait_s + 1.0)
    world.hand.acknowledge(world)


def hold_select(world: World, for_s: float) -> None:
    """Release all keys for a while, then hold SELECT for a time and release it."""
    world.wait(REST_S)
    world.device.press("select")
    world.wait(for_s)
    world.device.press(None)


class Hand(Protocol):
    """Somebody who operates the loop by one interface."""

    def begin_acknowledging(self, world: World) -> None:
        """Begin to acknowledge, without waiting for the effect."""

    def acknowledge(self, world: World) -> None:
        """Acknowledge the latched fault, and wait until the firmware has received it."""

    def switch(self, world: World, *, on: bool) -> None:
        """Switch the loop on or off, if it has a switch."""

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        """Set the setpoint, °C."""


def hand_of(site: Site) -> Hand:
    """Return the operator of the loop, by its best interface."""
    facts = facts_of(site.controller)
    if site.facts.switched:
        if facts.modbus is not None:
            return _Master()
        if site.facts.touched:
            return _AtDisplay()
        return _AtMenu() if site.has_menu else _AtPanel()
    if site.facts.commanded:
        return _Host()
    if not site.has_keys and facts.gcode is not None:
        return _Beside(_Host())
    return _AtKeys() if site.has_keys or facts.nextion is None else _Beside(_AtDisplay())


class _Master:
    """A master on a Modbus line."""

    def begin_acknowledging(self, world: World) -> None:
        world.device.write("acknowledge", True)

    def acknowledge(self, world: World) -> None:
        world.write("acknowledge", True)

    def switch(self, world: World, *, on: bool) -> None:
        world.write(f"{world.site.loop_name}.enabled", on)

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        world.write(f"{world.site.loop_name}.setpoint", setpoint_c)


class _Unswitched:
    """Somebody at a loop without a switch: only the setpoint may turn such a loop off."""

    def switch(self, world: World, *, on: bool) -> None:
        del on
        raise LookupError(f"Loop {world.site.loop_name} has no switch.")


class _Host(_Unswitched):
    """A host that speaks G-code."""

    def begin_acknowledging(self, world: World) -> None:
        world.device.send("M999")

    def acknowledge(self, world: World) -> None:
        world.send("M999")

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        world.send(f"{world.site.heat_command} S{setpoint_c:g}")


class _Beside(_Unswitched):
    """Somebody who operates another loop, and acknowledges the faults of all loops there."""

    def __init__(self, hand: Hand) -> None:
        self.begin_acknowledging = hand.begin_acknowledging
        self.acknowledge = hand.acknowledge

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        """Leave the setpoint: nobody can set it."""


class _AtDisplay:
    """Somebody at a touch display; its buttons send these commands."""

    def begin_acknowledging(self, world: World) -> None:
        world.device.send("#16;")

    def acknowledge(self, world: World) -> None:
        self._touch(world, "#16;")

    def switch(self, world: World, *, on: bool) -> None:
        self._touch(world, f"#2 {int(on)};")

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        self._touch(world, f"#3 {setpoint_c:g};")

    @staticmethod
    def _touch(world: World, command: str) -> None:
        world.device.send(command)
        world.run(TOUCH_S)


class _AtKeys(_Unswitched):
    """Somebody at UP, DOWN and SELECT."""

    def begin_acknowledging(self, world: World) -> None:
        hold_select(world, PRESS_S)

    def acknowledge(self, world: World) -> None:
        self.begin_acknowledging(world)
        world.run(PRESS_S)

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        step_k = world.site.key_step_k
        steps = round((setpoint_c - world.setpoint_c) / step_k) if step_k else 0
        world.press("up" if steps > 0 else "down", abs(steps))


class _AtPanel(_AtKeys):
    """Somebody at the keypad of a loop without programs, who reads the display."""

    def switch(self, world: World, *, on: bool) -> None:
        if not on:
            world.press("left")
            return
        for _ in range(PAGES):
            if not world.read_display()[1].startswith(SETPOINT):
                world.press("right")  # from the time, or a number, to the setpoint
        if world.read_display()[1].startswith(OFF):
            world.press("up")

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        self.switch(world, on=True)
        super().set_setpoint(world, setpoint_c)


class _AtMenu(_AtKeys):
    """Somebody at the keypad of a loop with programs: its values are LEFT of the first screen."""

    def switch(self, world: World, *, on: bool) -> None:
        world.press("left")
        world.press("select")
        world.press("up" if on else "down")
        if on:
            world.press("select")
        world.press("right")

    def set_setpoint(self, world: World, setpoint_c: float) -> None:
        world.press("left")
        self._hold(world, setpoint_c)
        super().set_setpoint(world, setpoint_c)
        world.press("right")

    @staticmethod
    def _hold(world: World, setpoint_c: float) -> None:
        """Hold a key until single presses are faster."""
        coarse_k = COARSE_STEPS * world.site.key_step_k
        if abs(setpoint_c - world.setpoint_c) < HELD_S * COARSE_STEPS * world.site.key_step_k:
            return
        world.device.press("up" if setpoint_c > world.setpoint_c else "down")
        world.until(lambda now: abs(setpoint_c - now.setpoint_c) <= coarse_k, LONGEST_HOLD_S)
        world.device.press(None)
        world.run(TOUCH_S)
