"""Flipped bits: those that once opened a heater, every one of them, and drawn ones."""

import re
import struct
from collections.abc import Callable, Iterator
from itertools import product
from random import Random
from typing import TypeVar

import pytest
from fault_machines import CODES, DECIDING, site_of
from rig.firmware import EXAMPLE_NAMES, controller_of, device_of, sources_of
from suite import SEED, amount

from heatwright.sim.avr import AvrError
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import start_up_s
from heatwright.sim.faults.controller import memory, upsets
from heatwright.sim.faults.effects import SHORTED
from heatwright.sim.faults.operation import programs
from heatwright.sim.faults.site import Site
from heatwright.sim.faults.witness import complaints
from heatwright.sim.faults.world import World
from heatwright.sim.reference.programs.state import FAILED, IDLE, PAUSED, RUNNING
from heatwright.spec.scenario.program_orders import Order

DRAWN = amount("upsets")
FLAGS = {"A": 0xFC, "B": 0x23}
"""Bits of UCSRA and UCSRB that say what happens on the line, and UDRIE."""
RECORDED_S = 5.0  # longer than the records of a fault and of a program's end take, at a byte a tick
T = TypeVar("T")


def deciding(site: Site) -> Iterator[tuple[str, int, int]]:
    variables = World(site, starts.Weather(20.0, 20.0)).device.variables
    loop = site.loop_name
    names = [
        "fault.code", "fault_complement", "gate.c:main_ticks", f"gate.c:{loop}_ticks",
        f"gate.c:{loop}_sensor_ticks", f"settings.{loop}_setpoint_c",
        f"settings.{loop}_maximum_c", f"loop_{loop}.c:next_enabled", f"loop_{loop}.enabled",
        "relay.c:closed", "relay.c:ticks",
    ]  # fmt: skip
    for name in names:
        if name in variables:
            yield name, variables[name].address, variables[name].size
    outputs, relay = site.controller.outputs, site.controller.safety.relay
    pins = {outputs[name].pin for name in (site.loop.heater, relay) if name}
    for port in {site.controller.board.pins[pin].port for pin in pins}:
        for register in (f"PORT{port}", f"DDR{port}"):
            yield register, variables[register].address, 1


def timer_registers(example: str, file: str) -> list[str]:
    """Name what a file sets anew, such as the pace of the tick."""
    started = sources_of(example)[file].partition("set_registers(")[2].partition("\n}")[0]
    kinds = r"TCCR\w+|OCR\w+|ICR\w+|TIMSK\w*|UBRR\d|UCSR\w+"
    named = re.findall(rf"^ +({kinds})", started, re.MULTILINE)
    return list(dict.fromkeys(named))


def some(bits: list[T], count: int) -> list[T]:
    """Choose about so many, the same ones for the same SUITE_SEED."""
    return Random(f"bits {SEED}").sample(bits, min(count, len(bits)))  # noqa: S311 - no secret


@pytest.mark.parametrize("state", ["latched", "off"])
@pytest.mark.parametrize("example", DECIDING)
def test_no_bit_of_what_decides_about_heat_opens_a_heater(example: str, state: str) -> None:
    site = site_of(example)
    bits = [
        (name, place, bit)
        for name, address, size in deciding(site)
        for place in range(address, address + size)
        for bit in range(8)
    ]
    for name, place, bit in some(bits, amount("deciding_bits")):
        upset = upsets.Upset(0, site.loop_name, state, 0.0, "ram", place, bit)
        outcome = upsets.try_upset(site.controller, site.program, upset)
        assert outcome.result not in upsets.BAD, f"{name} {upset}: {outcome.words}"


@pytest.mark.parametrize("example", DECIDING)
def test_no_bit_of_the_clock_s_registers_slows_the_control(example: str) -> None:
    """With the prescaler at 1024 a heater was on for 194 s without a decision."""
    site = site_of(example)
    world, wrong = starts.heating(site), []
    watchdog = {"WDTCSR", "WDTCR"} & set(world.device.variables)
    for name in (*timer_registers(example, "clock.c"), *watchdog):
        variable = world.device.variables[name]
        for bit in range(8 * variable.size):
            world.device.avr.flip(variable.address + bit // 8, bit % 8)
            try:
                world.run(site.controller.safety.watchdog_s + 1.0)
                before = world.loop("steps")
                world.run(10 * site.loop.period_s)
            except AvrError:  # a mode that is not simulated
                world = starts.heating(site)
                continue
            if abs((world.loop("steps") - before) % 65536 - 10) > 1:
                wrong.append((name, bit))
    assert wrong == []


@pytest.mark.parametrize("example", ["extruder", "fabricator", "feeder"])
def test_no_bit_of_a_pulse_width_s_timer_stays_flipped(example: str) -> None:
    """A timer that stands leaves the pin as it is, and an inverted pin heats when it should not."""
    site = site_of(example)
    world, heater = starts.heating(site), site.controller.outputs[site.loop.heater]

    def values(register: str) -> set[int]:
        place, found = world.device.variables[register], set()
        for _ in range(20):
            world.run(site.loop.period_s / 10)
            raw = world.device.avr.read_ram(place.address, place.size)
            found.add(int.from_bytes(raw, "little"))
        return found

    names = timer_registers(example, f"output_{site.loop.heater}.c")
    assert names
    for name in names:
        variable, healthy = world.device.variables[name], values(name)
        if re.fullmatch(r"TCCR\dA", name):  # channel A is connected, or the heater is off or full
            connected = 0x80 if heater.active == "high" else 0xC0
            healthy |= {value & 0x0F | bits for value in healthy for bits in (0, connected)}
        for bit in range(8 * variable.size):
            try:
                world.device.avr.flip(variable.address + bit // 8, bit % 8)
                world.run(2 * site.loop.period_s)
                assert values(name) <= healthy or world.fault, f"{name} bit {bit}"
            except AvrError:  # a mode that is not simulated
                world = starts.heating(site)
            if world.fault:  # as of the current, before the register was written
                world = starts.heating(site)


def heard(device: AvrDevice, file: str) -> int:
    """Say something on the line of a port, and count what comes back on it within two seconds."""
    said: dict[str, tuple[Callable[[], object], Callable[[], int]]] = {
        "serial": (lambda: None, lambda: len(device.plotter.lines)),
        "modbus_line": (lambda: None, lambda: device.master.polls),
        "host": (lambda: device.host.send_bytes(b"\nM105\n"), lambda: len(device.host.lines)),
        "nextion_port": (
            lambda: device.display.send(b"\0\0\0\xff\xff\xff"),
            lambda: device.display.instructions,
        ),
        "log_port": (
            lambda: device.log_reader.send_bytes(b"\nhelp\n"),
            lambda: len(device.log_reader.lines),
        ),
    }
    say, count = said[file]
    before = count()
    say()
    device.advance(device.time_s + 2.0)
    return count() - before


@pytest.mark.parametrize(
    ("example", "file"),
    [("chamber", "serial"), ("barrel", "modbus_line"), ("extruder", "host"),
     ("kiln", "nextion_port"), ("kiln", "log_port")],
)  # fmt: skip
def test_no_bit_of_a_serial_line_s_registers_cuts_it_off(example: str, file: str) -> None:
    """Neither receiver nor transmitter, speed nor format, nor the direction of a driver."""

    def healthy() -> AvrDevice:
        device = device_of(example, 20.0)
        device.advance(6.0)
        return device

    device, cut = healthy(), []
    names = timer_registers(example, f"{file}.c")
    assert len([name for name in names if name.startswith("U")]) == len(["UBRR", *"ABC"])
    bits = [
        (name, device.variables[name].address + bit // 8, bit % 8)
        for name in names
        for bit in range(8 * device.variables[name].size)
    ]
    if file == "modbus_line":
        pin = controller_of(example).board.pins["D2"]
        driver = (f"PORT{pin.port}", f"DDR{pin.port}")
        bits += [(name, device.variables[name].address, pin.bit) for name in driver]
        bits += [("phase", device.variables["phase"].address, bit) for bit in range(8)]
    for name, address, bit in bits:
        before = device.avr.read_ram(address, 1)[0]
        try:
            device.avr.flip(address, bit)
            device.advance(device.time_s + 2.0)
            flags = FLAGS.get(name[-1], 0) if name.startswith("UCSR") else 0
            changed = (before ^ device.avr.read_ram(address, 1)[0]) & ~flags
            if changed or not heard(device, file):
                cut.append((name, bit))
                device = healthy()
        except AvrError:  # a mode that is not simulated
            device = healthy()
    assert cut == []


@pytest.mark.parametrize("example", DECIDING)
def test_no_bit_of_the_record_of_a_fault_forgets_it(example: str) -> None:
    """The bits are those of the newest record, and of any other, as a loss of power leaves each."""
    site = site_of(example)
    world = memory.latched(site)
    image = world.device.avr.eeprom.contents
    used = [place for place in range(len(image)) if image[place] != 0xFF]
    bits = [(place, bit) for place in used for bit in range(8)]
    forgotten = []
    for place, bit in some(bits, amount("record_bits")):
        damaged = bytearray(image)
        damaged[place] ^= 1 << bit
        world.device.avr.eeprom.contents = bytes(damaged)
        world.power_cut()
        world.device.advance(world.device.time_s + start_up_s(site))
        if not world.fault:
            forgotten.append((place, bit))
        world.device.avr.eeprom.contents = image
        world.power_cut()
    assert forgotten == []


@pytest.mark.parametrize("example", DECIDING)
def test_a_jump_to_what_restores_a_fault_at_the_start_clears_none(example: str) -> None:
    """A drawn one did, on the extruder, with a register that pointed to zeros."""
    site = site_of(example)
    restores = site.program.function("fault_restore")
    unused = site.program.static_ram[1] + 64
    for address, r24 in product(range(restores.start, restores.end, 2), (unused & 0xFF, 0)):
        world = memory.latched(site)
        avr = world.device.avr
        avr.write_ram(unused, bytes(64))
        avr.write_ram(0, bytes(2) + 15 * unused.to_bytes(2, "little"))  # each pair but r1:r0
        avr.write_ram(24, bytes([r24]))
        avr.jump(address)
        world.run(3 * site.loop.period_s)
        assert world.fault, f"0x{address:04X}, r24 = {r24}"


def test_a_relay_that_a_flipped_bit_closes_opens_in_the_next_tick() -> None:
    """The kiln went to 1,125 °C so, with its switch shorted."""
    site = site_of("kiln")
    pin = site.controller.board.pins[site.controller.outputs[str(site.controller.safety.relay)].pin]
    for name, bit in (("relay.c:closed", 0), (f"PORT{pin.port}", pin.bit)):
        world = memory.latched(site)
        world.wiring.heat[site.loop.heater] = SHORTED
        before_c = world.sensed_c
        world.device.avr.flip(world.device.variables[name].address, bit)
        world.run(60.0)
        assert world.sensed_c < before_c
        assert world.fault


BEGINS = {programs.under_way: RUNNING, programs.paused: PAUSED, starts.cold: IDLE}
"""Worlds, and the state of the program in them."""


def moves_no_firing(site: Site, begin: Callable[[Site], World], count: int) -> None:
    world, state = begin(site), BEGINS[begin]
    variables = world.device.variables
    bits = [
        (name, variables[name].address + bit // 8, bit % 8)
        for name in ("program", "loaded", "program.c:seal", "next_order")
        for bit in range(8 * variables[name].size)
    ]
    setpoint = variables[f"settings.{site.loop_name}_setpoint_c"]
    for name, place, bit in (("setpoint", setpoint.address, 0), bits[0], *some(bits, count)):
        assert (world.fault, world.device.read("program.state")) == (0, state)
        world.device.avr.flip(place, bit)
        seems_idle = world.device.read("program.state") == IDLE
        ended = world.device.read("program.ended") if seems_idle else FAILED
        world.run(2 * site.loop.period_s)
        assert world.fault == CODES["memory_damaged"], (name, place, bit)
        assert world.device.read("program.state") == IDLE
        assert world.device.read("program.ended") == ended
        world.run(RECORDED_S)
        world.power_cut()
        world.run(2 * site.loop.period_s)
        assert world.device.read("program.state") == IDLE, (name, place, bit)
        world = begin(site)
    place = variables["next_argument"].address
    for bit in range(8):
        world.device.avr.flip(place, bit)
        world.run(2 * site.loop.period_s)
        assert world.device.read("program.state") == state, bit
        world.device.avr.write_ram(place, b"\0")


@pytest.mark.parametrize("begin", BEGINS)
def test_no_bit_of_a_program_moves_a_firing(begin: Callable[[Site], World]) -> None:
    """What it is doing, and where it goes; an order that nobody gave does not heat either."""
    moves_no_firing(site_of("kiln"), begin, amount("program_bits"))


@pytest.mark.parametrize("name", ["program.to_c", "program.state", "program.c:loaded"])
def test_what_flips_within_a_step_is_found_in_the_next(name: str) -> None:
    """It was sealed at the step's end, and a firing ran at twice its slope."""
    world = programs.under_way(site_of("kiln"))
    counts, struck = world.site.program.function("program_count"), []

    def strike(end_s: float) -> None:
        avr = world.device.avr
        if not struck and avr.run_to_code(counts, world.device.cycle_at(end_s)):
            memory.flip(world, name, 1, byte=-1)
            struck.append(avr.cycle)
        world.device.advance(end_s)

    while not struck:
        world.act_within(strike)
    world.run(2 * world.site.loop.period_s)
    assert world.fault == CODES["memory_damaged"]


@pytest.mark.parametrize("order", ["stop", "pause"])
def test_no_bit_of_an_order_to_stop_keeps_the_heater_on(order: Order) -> None:
    for bit in range(8):
        world = programs.under_way(site_of("kiln"))
        world.device.program(order)
        world.until(lambda now: now.device.read("next_order") != 0, RECORDED_S)
        assert world.device.read("next_order") != 0
        memory.flip(world, "next_order", bit)
        world.run(2 * world.site.loop.period_s)
        began_s = world.now_s
        world.run(3 * world.site.loop.period_s)
        assert world.heater.last_on_s(began_s) is None, bit


@pytest.mark.parametrize("example", ["kiln", "kiln_uno"])
@pytest.mark.parametrize("name", ["fault.code", "fault_complement", "settings.chamber_setpoint_c"])
def test_firmware_and_model_end_a_program_alike(example: str, name: str) -> None:
    """Where the latch or a setpoint is damaged, and where a fault is latched already."""
    for faulty in (False, True) if name.startswith("settings") else (False,):
        world = programs.under_way(site_of(example))
        if faulty:
            memory.cut_line(world)
            world.run(10 * world.site.loop.period_s)
            assert world.fault
        memory.flip(world, name, 0)
        world.run(3 * world.site.loop.period_s)
        assert world.fault
        lying = (world.site.loop_name,)
        assert list(complaints(world, lying, current_lies=False)) == []


@pytest.mark.parametrize("maximum_c", [float("nan"), 4600.0, float("inf")])
def test_the_spec_s_maximum_counts_beside_one_that_is_damaged(maximum_c: float) -> None:
    world = starts.hot(site_of("kiln"))
    name = world.site.loop_name
    place = world.device.variables[f"settings.{name}_maximum_c"].address
    world.device.avr.write_ram(place, struct.pack("<f", maximum_c))
    world.run(3 * world.site.loop.period_s)
    assert world.fault == CODES["memory_damaged"]


KNOWN: dict[tuple[str, int], str] = {}
"""Bad cases that are a risk which stays, by example and number: what happened, and how probable it
is as cases of those that were struck. docs/safety.md lists them, too."""


@pytest.mark.parametrize("number", range(DRAWN))
@pytest.mark.parametrize("example", EXAMPLE_NAMES)
def test_a_drawn_upset_opens_no_heater(example: str, number: int) -> None:
    site = site_of(example)
    upset = upsets.draw(site.controller, site.program, number, 1)
    outcome = upsets.try_upset(site.controller, site.program, upset)
    is_bad = outcome.result in upsets.BAD and (example, number) not in KNOWN
    assert not is_bad, f"{upset}: {outcome.words}"


@pytest.mark.parametrize(
    "example", [name for name in EXAMPLE_NAMES if site_of(name).controller.safety.relay is None]
)
def test_a_heater_that_stays_on_is_found_however_slow_the_machine(
    example: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its switch is shorted. A minute of it makes no machine too hot, and counted as nothing."""
    site = site_of(example)

    def shorted(world: World, upset: upsets.Upset, after_s: float) -> float:
        del upset, after_s
        world.wiring.heat[site.loop.heater] = SHORTED
        return world.now_s

    monkeypatch.setattr(upsets, "_strike", shorted)
    upset = upsets.Upset(0, site.loop_name, "hot", 0.0, "ram", 0, 0)
    assert upsets.try_upset(site.controller, site.program, upset).result in upsets.BAD


@pytest.mark.parametrize("example", ["chamber", "kiln"])
def test_every_state_that_a_loop_can_have_is_drawn(example: str) -> None:
    site, random = site_of(example), Random(1)  # noqa: S311 - no secret
    drawn = {upsets.draw_state(site, random).partition(" ")[0] for _ in range(100)}
    assert drawn == {*upsets.STATES, *([upsets.PROGRAMMED] if site.facts.programmed else [])}
    for state in {upsets.draw_state(site, random) for _ in range(100)}:
        world = upsets.begun(site, state)
        assert bool(world.fault) == (state == "latched")
        if state.startswith(upsets.PROGRAMMED):
            assert world.device.read("program.segment") == int(state.split()[1])
