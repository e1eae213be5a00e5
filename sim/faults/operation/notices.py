"""Whether each interface of the controller shows a latched fault to its users."""

from collections.abc import Iterator

from heatwright.sim.faults.world import World
from heatwright.spec import RULES, facts_of


def complaints(world: World, code: int) -> Iterator[str]:
    """Yield each interface that does not show the fault, and what it shows instead."""
    site, rule = world.site, RULES[code]
    wanted = f"E{rule.code:02d} {rule.display}"
    shown = f"E{rule.code:02d} HOLD SELECT" if world.is_locked_out else wanted
    if site.has_keys and (line := world.read_display()[1]).rstrip() != shown:
        yield f"the display shows {line!r}, not {shown!r},"
    if world.device.crystal_hz != site.controller.board.clock_hz:
        return  # all serial lines have a wrong baud rate: no message on them is readable
    if site.facts.hosted and not world.device.host.texts(f"Error:{wanted}"):
        yield f"the host did not receive {wanted!r},"
    if facts_of(site.controller).modbus is not None and not _master_knows(world, code):
        yield f"the master does not read fault {wanted!r},"
    if facts_of(site.controller).nextion is not None:
        page = world.device.display.page
        if page != f"fault{code:02d}":
            yield f"the touch display shows page {page}, not fault{code:02d},"


def _master_knows(world: World, code: int) -> bool:
    """Whether the master has read the fault, or is unplugged."""
    master = world.device.master
    return not master.is_plugged or master.fault == code
