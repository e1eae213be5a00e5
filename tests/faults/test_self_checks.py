"""The controller checks itself: what is broken is found, and what belongs there trips nothing."""

import re
import struct
from random import Random

import pytest
from fault_machines import CODES, DECIDING, site_of
from rig.firmware import CLOCK_HZ, changed, controller_of, device_of, sources_of, whole
from suite import SEED, amount

from heatwright.sim.avr import Avr, AvrError
from heatwright.sim.binary.elf import Elf, Function
from heatwright.sim.device import PROOF, AvrDevice
from heatwright.sim.faults import starts
from heatwright.sim.faults.bounds import TICK_S, flash_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.controller.upsets import BAD, Upset, begun, draw_state, try_upset
from heatwright.sim.faults.site import OfState, Site
from heatwright.sim.native.pins import Level

SAFETY = re.compile(r"(checks|clock|fault|flash|gate|guard_\w+|loop_\w+|main|output_\w+|relay)\.c")
"""The files whose functions decide about heat."""
MISSED, CHANCE = 1 / 1000, 1 / 100
SHOWS = 5000
"""So many are counted as they are: where 0.3 of 1000 are missed, 6 of these are once in 225."""
BOOT_BYTES = 512
FLAGS = 32
IN_R17_SREG = (0xB71F).to_bytes(2, "little")  # the instruction that reads the flags
PATTERNS_CYCLES = 120  # more than the test of the registers takes
EXTRF = 1
MCUSR = 0x54  # in the data space
CHAMBER = "chamber"
BURST = "window: 1 s, resolution: 10 ms"  # the kiln's pulses


def broken(spec: str, file: str, statement: str, by: str) -> Elf:
    """Compile a firmware with another statement in the place of one that stands once in a file."""
    return whole(spec, changed={file: changed(sources_of(spec)[file], (statement, by))})


def powered(until_s: float, program: Elf | None = None) -> AvrDevice:
    """Power the chamber on at 19 °C; with another binary if there is one."""
    device = device_of(CHAMBER, 19.0, program)
    device.advance(until_s)
    return device


def safety_bytes(site: Site, example: str) -> list[int]:
    texts = [text for name, text in sources_of(example).items() if SAFETY.fullmatch(name)]
    defined = {
        name
        for text in texts
        for name in re.findall(r"^[a-z][^;=\n]*?(\w+)\([^;\n]*\n\{", text, re.M)
    }
    functions = [each for each in site.program.functions if each.name in defined]
    assert len(functions) > 20
    return [place for each in functions for place in range(each.start, each.end)]


def most_missed(tried: int) -> int:
    """Return how many of the tried flips may be missed: one in a thousand. A sample that is too
    small to show that may have as many as chance gives once in a hundred times, where the rate is
    one in a thousand."""
    if tried >= SHOWS:
        return int(tried * MISSED)
    chance, most = (1 - MISSED) ** tried, 0
    more = 1 - chance
    while more > CHANCE:
        most += 1
        chance *= (tried - most + 1) / most * MISSED / (1 - MISSED)
        more -= chance
    return most


def test_how_many_may_be_missed() -> None:
    """By the table of the binomial distribution."""
    assert [most_missed(tried) for tried in (10, 300, 1000, 5000)] == [0, 2, 4, 5]


@pytest.mark.parametrize("example", DECIDING)
def test_a_flip_in_a_safety_function_is_found_in_a_round(example: str) -> None:
    """Told, or ended by a reset or by leaving what is simulated; and no heater is on then. But for
    one in a thousand: a flip in what judges the check itself, docs/safety.md lists them."""
    site, missed = site_of(example), []
    places, random = safety_bytes(site, example), Random(f"flash {SEED} {example}")  # noqa: S311
    tried = amount("flash_flips")
    for _ in range(tried):
        place, bit = random.choice(places), random.randrange(8)
        state = draw_state(site, random)
        world = begun(site, state)
        world.device.avr.take_resets()
        world.device.avr.flip_flash(place, bit)
        try:
            world.run(flash_s(site.program) + 1.0)
            since_s = world.now_s
            told = world.until(OfState(lambda now: now.fault != 0), 3 * site.loop.period_s)
        except AvrError:
            continue
        if (
            not (told or len(world.device.avr.take_resets()))
            or world.heaters.last_on_s(since_s) is not None
        ):
            missed.append((state, hex(place), bit))
    assert len(missed) <= most_missed(tried), missed


IN_TIME = "period_start) < change"


@pytest.mark.parametrize(
    ("spec", "loop", "file", "statement", "by"),
    [
        # the count of the ticks; what the round has left; the ticks do not run out
        (CHAMBER, "air", "flash.c", "flash_address left = ticks_left;", "flash_address left = 9;"),
        (CHAMBER, "air", "flash.c", "return residue == 0;", "return true;"),
        (CHAMBER, "air", "flash.c", "ticks_left = left - 1u;", ""),
        # It looked again until it was in time: damaged, it looked for ever, or most of the time.
        ("extruder", "nozzle", "output_heater.c", f"{IN_TIME}) {{",
         f"{IN_TIME} && looks == MOST_LOOKS) {{"),
    ],
)  # fmt: skip
def test_a_damaged_program_is_told_though_something_else_is_damaged_too(
    spec: str, loop: str, file: str, statement: str, by: str
) -> None:
    program = broken(spec, file, statement, by)
    world = starts.heating(Site(controller_of(spec), loop, program))
    memory.flip_flash(world)
    world.run(flash_s(program) + 1.0)
    assert world.fault == CODES["flash_damaged"]


def test_a_check_that_takes_no_byte_is_told() -> None:
    """From 0 it would end with 0, too."""
    read, nothing = "_crc16_update(sum, READ_BYTE(at))", "_crc16_update(sum, 0)"
    device = powered(1.0, broken(CHAMBER, "flash.c", read, nothing))
    assert device.read("fault.code") == CODES["flash_damaged"]


def test_a_main_loop_without_its_checks_is_ended_by_the_watchdog() -> None:
    """It runs, gives no permit, and would stand so for ever without a word."""
    device = powered(1.0, broken(CHAMBER, "main.c", "    checks_tick();\n", ""))
    device.avr.take_resets()
    device.advance(4.0)
    assert len(device.avr.take_resets()) > 0
    assert device.read("fault.code") == CODES["watchdog_reset"]


def test_a_damaged_program_heats_no_more_whoever_acknowledges() -> None:
    world = starts.heating(site_of(CHAMBER))
    memory.flip_flash(world)
    world.run(flash_s(world.site.program))
    assert world.fault == CODES["flash_damaged"]
    since_s = world.now_s
    for _ in range(2):
        world.acknowledge()
        world.run(10.0)
        assert world.fault == CODES["flash_damaged"]
    assert world.heaters.last_on_s(since_s) is None


@pytest.mark.parametrize("cause", ["external", "brown_out"])
def test_a_boot_loader_and_resets_trip_nothing_of_it(cause: str) -> None:
    """What is behind the program in the flash is not the program's."""
    controller, program = controller_of(CHAMBER), whole(CHAMBER)
    device = AvrDevice(controller, program)
    boot = Random(1).randbytes(BOOT_BYTES)  # noqa: S311 - no secret
    for place, byte in enumerate(boot, controller.board.flash_bytes - BOOT_BYTES):
        device.avr.put_flash(place, byte)
    for _ in range(3):
        device.advance(device.time_s + flash_s(program))
        assert device.read("fault.code") in (0, CODES["brown_out"])
        device.avr.reset(cause)  # type: ignore[arg-type]


def test_without_self_checks_nothing_of_them_is_there() -> None:
    without = changed("chamber", ("safety:", "safety:\n  self_checks: false"))
    assert not {"flash.c", "checks.c"} & set(sources_of(without))
    assert "FLASH" not in sources_of(without)["fault.h"]
    assert {"flash.c", "checks.c"} <= set(sources_of(CHAMBER))


def behind_call(program: Elf, caller: str, called: str) -> tuple[int, int]:
    """Return where a function calls another, by `call` or the shorter `rcall`, and what follows."""
    inside, target = program.function(caller), program.function(called).start
    for place in range(inside.start, inside.end, 2):
        word, word_after = struct.unpack_from("<HH", program.flash, place)
        if word == 0x940E and 2 * word_after == target:
            return place, place + 4
        if word >> 12 == 0xD and (place + 2 + 2 * word - target) % 0x2000 == 0:
            return place, place + 2
    raise AssertionError(f"{caller} does not call {called}")


def test_a_jump_over_the_guard_gives_no_permit() -> None:
    """What was not judged does not count, and is told in the next tick."""
    world = starts.heating(site_of(CHAMBER))
    call, behind = behind_call(world.site.program, "loop_air_tick", "guard_air_step")
    avr, device = world.device.avr, world.device
    for _ in range(200):
        avr.run(0.01)
        if device.read("loop_air.c:ticks_left") == 1:
            break
    assert avr.run_to_code(Function(call, call + 2, "call"), avr.cycle + round(0.02 * avr.clock_hz))
    avr.jump(behind)
    avr.run(0.03)
    assert device.read("fault.code") == CODES["sequence_broken"]
    assert not device.outputs["heater"].on


LATCHES, LATCHES_NOTHING = "    set_code(code);\n    fault.t", "    fault.t"


def off_by_verdict(program: Elf) -> None:
    """Judge a program whose trip latches nothing: while a rule is broken its heater is off."""
    device = powered(5.0, program)
    device.avr.take_resets()
    for celsius, is_on in ((19.0, True), (-30.0, False), (19.0, True)):  # the minimum is -10
        device.sense("air", celsius)
        device.advance(device.time_s + 6.0)
        device.on_fraction("heater")
        device.advance(device.time_s + 6.0)
        assert (device.on_fraction("heater") > 0.5) == is_on
    assert (device.read("fault.code"), len(device.avr.take_resets())) == (0, 0)


def test_a_broken_rule_is_off_though_nothing_is_latched() -> None:
    off_by_verdict(broken(CHAMBER, "fault.c", LATCHES, LATCHES_NOTHING))


@pytest.mark.parametrize("state", ["latched", "off"])
def test_no_jump_into_a_control_step_opens_a_heater(state: str) -> None:
    site = site_of(CHAMBER)
    step = site.program.function("loop_air_tick")
    random = Random(f"jump {SEED} {state}")  # noqa: S311 - no secret
    for number in range(amount("jumps")):
        place = random.randrange(step.start, step.end, 2)
        upset = Upset(number, site.loop_name, state, random.random(), "jump", place, 0)
        outcome = try_upset(site.controller, site.program, upset)
        assert outcome.result not in BAD, f"{upset}: {outcome.words}"


def keep(avr: Avr, place: int, bit: int, *, at: bool) -> None:
    """Have a bit of the data space be what it is stuck at."""
    if bool(avr.read_ram(place, 1)[0] >> bit & 1) != at:
        avr.flip(place, bit)


@pytest.mark.parametrize("at", [False, True])
def test_the_start_ends_where_a_register_is_stuck(at: bool) -> None:
    """Each bit of each register, and of the flags as they are read, but for the last."""
    program = whole(CHAMBER)
    test = program.function("test_registers")
    device = device_of(CHAMBER)
    avr = device.avr
    for place in (*range(32), FLAGS):
        for bit in range(7 if place == FLAGS else 8):
            avr.jump(test.start)
            for _ in range(PATTERNS_CYCLES):
                last = program.flash[avr.program_counter :][:2]
                avr.run_to(avr.cycle + 1)
                if place < FLAGS:
                    keep(avr, place, bit, at=at)
                elif last == IN_R17_SREG:
                    keep(avr, 17, bit, at=at)
            assert test.start <= avr.program_counter < test.end, (place, bit)
    avr.jump(test.start)
    avr.run_to(avr.cycle + PATTERNS_CYCLES)
    assert not test.start <= avr.program_counter < test.end
    assert not device.outputs["heater"].on


@pytest.mark.parametrize("at", [False, True])
def test_a_cell_of_the_ram_that_is_stuck_is_told_and_the_others_keep_what_they_hold(
    at: bool,
) -> None:
    """One that the program does not use, so that nothing else shows it."""
    program = whole(CHAMBER)
    test = program.function("ram_tick")
    for bit in range(8):
        device = powered(0.2)
        avr, place = device.avr, device.variables["ram.c:place"]
        cell = program.static_ram[1] + 100
        avr.write_ram(place.address, (cell - 1).to_bytes(2, "little"))
        keep(avr, cell, bit, at=at)
        before = avr.read_ram(cell - 4, 8)
        until = avr.cycle + round(0.015 * avr.clock_hz)
        while avr.run_to_code(test, until):
            keep(avr, cell, bit, at=at)
        assert device.read("fault.code") == CODES["ram_damaged"], bit
        assert device.read("ram.c:place") in (cell - 1, cell)
        assert avr.read_ram(cell - 4, 8) == before


def test_a_watchdog_that_does_not_reset_is_told() -> None:
    reset = sources_of(CHAMBER)["reset.c"]
    proof = reset.index("void reset_prove_watchdog")
    dead = reset[:proof] + reset[proof:].replace("    wdt_enable(WDTO_15MS);\n", "", 1)
    device = powered(1.0, whole(CHAMBER, changed={"reset.c": dead}))
    assert device.read("fault.code") == CODES["clock_wrong"]
    assert not device.outputs["heater"].driven


@pytest.mark.parametrize("cleared", [False, True])
def test_a_reset_while_the_watchdog_is_waited_for_is_no_fault(cleared: bool) -> None:
    """As where a plug bounces; a boot loader may have cleared what tells of it."""
    device = powered(0.003)
    for time_s in (0.003, 0.012):
        device.advance(time_s)
        device.avr.reset()
        if cleared:
            device.avr.write_ram(MCUSR, b"\0")
    device.advance(2.0)
    assert device.read("fault.code") == 0
    assert len(device.take_resets()) == 2
    if not cleared:
        assert device.read("reset_cause") == 1 << EXTRF


@pytest.mark.parametrize(
    ("times", "found"), [(0.5, "clock_wrong"), (0.9, None), (1.1, None), (1.6, "clock_wrong")]
)
def test_the_clock_is_measured(times: float, found: str | None) -> None:
    """By the watchdog's oscillator, which is not exact itself."""
    device = device_of(CHAMBER, 19.0)
    device.crystal_hz = round(times * CLOCK_HZ)
    device.power_cycle()
    device.avr.run_to(round(0.5 * device.crystal_hz))
    assert device.read("fault.code") == (CODES[found] if found else 0)


def test_no_jump_into_the_watchdogs_proof_is_a_start_that_nobody_is_told_of() -> None:
    waits = whole(CHAMBER).function(PROOF)
    reset = 0
    for place in range(waits.start, waits.end, 2):
        device = powered(2.5)
        device.avr.take_resets()
        device.avr.jump(place)
        try:
            device.avr.run(0.5)
        except AvrError:
            continue  # it returned to where nobody had called it
        resets = len(device.avr.take_resets())
        assert not resets or device.read("fault.code") == CODES["watchdog_reset"], hex(place)
        reset += resets > 0
    assert reset


def test_a_cell_of_the_eeprom_that_takes_no_write_is_told() -> None:
    """Any byte of a record, as soon as it has been written: of one that says that all is well."""
    for byte in range(5):
        device = powered(3.0)
        avr = device.avr
        device.sense("air", 60.0)  # a jump
        device.advance(8.0)
        device.press("select")
        device.advance(8.3)
        device.press(None)
        device.advance(8.4)
        assert device.read("fault.code") == 0
        before = avr.eeprom.writes
        while avr.eeprom.writes <= before + byte:
            avr.run(0.001)
        written = avr.eeprom.writing
        assert written is not None
        image = bytearray(avr.eeprom.contents)
        image[written.address] ^= 1
        avr.eeprom.contents = bytes(image)
        avr.run(0.03)
        assert device.read("fault.code") == CODES["eeprom_worn"], byte


def test_a_main_loop_without_its_gate_is_told_and_lets_the_heater_go() -> None:
    """The interrupt comes and wakes the main loop, but nobody counts the permits any more."""
    device = powered(1.0, broken(CHAMBER, "clock.c", "    gate_tick();\n", ""))
    assert device.read("fault.code") == CODES["sequence_broken"]
    assert not device.outputs["heater"].driven


@pytest.mark.parametrize("level", ["high", "low"])
@pytest.mark.parametrize(
    ("pulses", "windows"), [(BURST, 1), ("window: 2 s, resolution: 20 ms, distribution: spread", 2)]
)
def test_a_heater_s_pin_that_is_held_is_told_and_the_relay_opens(
    pulses: str, windows: int, level: str
) -> None:
    """By whatever holds it: nothing but the relay ends the heat of one that is held on. Pulses of
    two ticks never show three looks in turn at one level."""
    world = starts.heating(site_of(changed("kiln", (BURST, pulses))))
    device, name = world.device, world.site.loop.heater
    switch = device.outputs[name]
    device.avr.pins.drive(switch.pin, level)
    within_s = windows * world.site.controller.switches[name].window_s + memory.HELD_S
    assert world.until(OfState(lambda now: now.fault != 0), within_s)
    assert world.fault == CODES["pin_held"]
    world.run(0.1)
    assert device.relay is not None
    assert switch.on == (level == switch.active)
    assert not device.relay.closed


@pytest.mark.parametrize("example", ["extruder", "fabricator", "feeder"])
def test_a_pulse_width_s_pin_that_is_held_on_is_told_while_it_must_be_off(example: str) -> None:
    """By interrupts, by timer, active low; no look at a pin that pulses tells anything."""
    world = starts.heating(site_of(example))
    heater = world.site.loop.heater
    switch = world.device.outputs[heater]
    world.run(2.0)
    assert world.fault == 0
    world.switch_off()
    world.run(2 * world.site.loop.period_s)
    world.device.avr.pins.drive(switch.pin, switch.active)
    world.device.advance(world.now_s + memory.HELD_S)
    assert world.fault == CODES["pin_held"]


@pytest.mark.parametrize(("example", "within_s"), [(CHAMBER, 4 * TICK_S), ("kiln", 1.1)])
def test_a_pin_that_is_disturbed_for_two_looks_is_not_held(example: str, within_s: float) -> None:
    """The third in turn tells; of pulses in the same window, or the next."""
    world = starts.heating(site_of(example))
    switch, pins = world.device.outputs[world.site.loop.heater], world.device.avr.pins
    off: Level = "low" if switch.active == "high" else "high"
    for _ in range(20):
        pins.drive(switch.pin, off)
        world.device.advance(world.now_s + 2 * TICK_S)
        pins.drive(switch.pin, None)
        world.device.advance(world.now_s + TICK_S)
    assert world.fault == 0
    pins.drive(switch.pin, off)
    world.device.advance(world.now_s + within_s)
    assert world.fault == CODES["pin_held"]
