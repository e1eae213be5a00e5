"""Faults at the touch display: unplugged, another baud rate, floods, random touches."""

import random
from collections.abc import Iterator

from heatwright.sim.faults import starts
from heatwright.sim.faults.fault import Act, Fault, harmless
from heatwright.sim.faults.operation.operators import keeps_time
from heatwright.sim.faults.world import Site, World
from heatwright.spec import facts_of
from heatwright.spec.nextion import HEIGHT, WIDTH

WATCH_S = 60.0
"""Longer than the 30 s after which the firmware sends everything again."""
AWAY_S = 20.0
OTHER_BAUD = 9600
"""The baud rate of a new display."""
SEED = 6
TOUCHES = 60
FLOOD_S = 20.0
FLOOD_BYTES = 1000
"""Nearly a tenth of a second at 115200 baud: the line is hardly ever quiet."""
BELOW_ALL, BEYOND_ALL = "-300", "99999"


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of a touch display that operates the loop; no rule may trip."""
    display = facts_of(site.controller).nextion
    if display is None or display.loop != site.loop_name:
        return
    for name, cause in (
        ("touch_display_unplugged", _unplug),
        ("touch_display_of_other_speed", _other_speed(display.baud)),
        ("touch_display_floods", _flood),
        ("touch_display_asks_too_much", _exceed_bounds),
    ):
        yield harmless(site, name, cause, WATCH_S, _unmoved)
    yield harmless(site, "touched_at_random", _play, WATCH_S)


def _unplug(world: World) -> None:
    world.device.display.unplug()
    world.run(AWAY_S)
    world.device.display.plug()


def _other_speed(baud: int) -> Act:
    """Set another baud rate: the display's messages are noise until the firmware corrects it."""

    def cause(world: World) -> None:
        display = world.device.display
        display.set_speed(OTHER_BAUD if baud != OTHER_BAUD else 2 * OTHER_BAUD)
        for _ in range(TOUCHES):
            if display.line.baud != baud:
                world.device.send("#2 0;#3 0;#17;")
            world.run(AWAY_S / TOUCHES)

    return cause


def _flood(world: World) -> None:
    """Send bytes that are no commands, almost without a pause."""
    noise = random.Random(SEED)  # noqa: S311 - noise, not a secret
    quiet = bytes(byte for byte in range(256) if byte != ord("#"))
    for _ in range(round(FLOOD_S / 0.1)):
        world.device.display.send(bytes(noise.choices(quiet, k=FLOOD_BYTES)))
        world.run(0.1)


def _exceed_bounds(world: World) -> None:
    """Send every command that takes a number with values out of bounds."""
    for command in (2, 3, 4, 8, 10, 13, 15, 20):
        for value in (BELOW_ALL, BEYOND_ALL, "1e9", "--1", "", "nan"):
            world.device.send(f"#{command} {value};")
            world.run(0.1)


def _unmoved(world: World) -> str:
    """Check that the setpoint is unchanged, no step was late, and the display is up to date."""
    if moved := starts.setpoint_moved(world, starts.highest_c(world.site)):
        return moved
    if not world.loop("enabled"):
        return "the loop was switched off"
    display = world.device.display
    shown = display.value("main.temp.val")
    if display.page != "main" or abs(float(shown) - world.loop("temperature_c")) > 1.0:
        return f"the touch display is wrong: page {display.page}, {shown} °C"
    return keeps_time(world)


def _play(world: World) -> None:
    """Touch the screen at random places."""
    chance = random.Random(SEED)  # noqa: S311 - random touches, not a secret
    for _ in range(TOUCHES):
        world.device.display.display.touch(chance.randrange(WIDTH), chance.randrange(HEIGHT))
        world.device.display.release()
        world.run(chance.choice((0.1, 0.5, 2.0)))
