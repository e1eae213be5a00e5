"""Faults of the Modbus master and its line: silence, insistence, values out of bounds, noise."""

import random
from collections.abc import Iterator

from heatwright.sim.faults import starts
from heatwright.sim.faults.controller.processor import stays_off
from heatwright.sim.faults.fault import Act, Fault, harmless
from heatwright.sim.faults.operation.hosts import lost
from heatwright.sim.faults.operation.operators import keeps_time
from heatwright.sim.faults.world import Site, World
from heatwright.sim.interfaces.modbus_rtu import frames
from heatwright.sim.native.characters import Format
from heatwright.spec import ModbusRtu, facts_of

WATCH_S = 60.0
INSISTS_S = 20.0
HEARD_S = 3.0
"""A master polls once a second: it has its answer within this time."""
REQUESTS = 40
EVERY_S = 0.7
"""Not synchronous with the polls, so that some of them are disturbed, too."""
BEYOND_K = 0.1
SEED = 4


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults that a master, or its line, can cause on a loop that it switches."""
    modbus = facts_of(site.controller).modbus
    if modbus is None:
        return
    if site.loop.protection.master_lost_after_s is not None:
        silent_s = site.loop.protection.master_lost_after_s
        yield lost(site, "master_lost", silent_s, lambda world: world.device.master)
    yield harmless(site, "master_insists_on_heat", _insist, WATCH_S, stays_off)
    for name, cause in (
        ("master_out_of_bounds", _exceed_bounds),
        ("bus_damaged", _damage),
        ("bus_of_other_format", _speak_otherwise(modbus)),
        ("bus_of_other_slaves", _speak_to_others),
    ):
        yield harmless(site, name, cause, WATCH_S, _unmoved)


def _insist(world: World) -> None:
    """Cut the power, and write ON repeatedly: without an OFF before, the loop must not heat."""
    world.power_cut()
    master = world.device.master
    wanted = master.request(f"{world.site.loop_name}.enabled", value=True).pdu
    for _ in range(round(INSISTS_S / EVERY_S)):
        master.ask(wanted)
        world.run(EVERY_S)


def _exceed_bounds(world: World) -> None:
    """Write setpoints just beyond the limits, and the most extreme ones of a register."""
    setpoint, name = world.site.loop.setpoint, f"{world.site.loop_name}.setpoint"
    for wanted_c in (
        setpoint.maximum_c + BEYOND_K,
        world.site.loop.protection.maximum_c,
        setpoint.minimum_c - BEYOND_K,
        3276.7,
        -3276.8,
    ):
        world.write(name, wanted_c)


def _lower(world: World) -> bytes:
    """Return the request that writes the lowest setpoint."""
    lowest_c = starts.setpoints_c(world.site)[0]
    return world.device.master.request(f"{world.site.loop_name}.setpoint", lowest_c).pdu


def _damage(world: World) -> None:
    """Send requests in which one bit is inverted."""
    chance = random.Random(SEED)  # noqa: S311 - noise, not a secret
    master = world.device.master
    request = frames.framed(master.address, _lower(world))
    for _ in range(REQUESTS):
        damaged = bytearray(request)
        damaged[chance.randrange(len(damaged))] ^= 1 << chance.randrange(8)
        master.bus.send(bytes(damaged))
        world.run(EVERY_S)


def _speak_otherwise(modbus: ModbusRtu) -> Act:
    """Send valid requests, in turn with another parity and at twice the baud rate."""
    other = Format(8, "even" if modbus.parity == "odd" else "odd", 1)

    def cause(world: World) -> None:
        master = world.device.master
        request = frames.framed(master.address, _lower(world))
        for turn in range(REQUESTS):
            if turn % 2:
                master.bus.send(request, form=other)
            else:
                master.bus.send(request, baud=2 * modbus.baud)
            world.run(EVERY_S)

    return cause


def _speak_to_others(world: World) -> None:
    """Send valid requests to every other slave address."""
    master, request = world.device.master, _lower(world)
    for address in range(1, 256):
        if address != master.address:
            master.bus.send(frames.framed(address, request))
            world.run(EVERY_S / 4)


def _unmoved(world: World) -> str:
    """Check that the setpoint is unchanged, no step was late, and valid requests are answered."""
    if moved := starts.setpoint_moved(world, starts.highest_c(world.site)):
        return moved
    polls = world.device.master.polls
    world.run(HEARD_S)
    if world.device.master.polls == polls:
        return "the controller no longer answers the master"
    return keeps_time(world)
