"""The controller checks itself: what is broken is found, and what belongs there trips nothing."""

import re
import struct
from random import Random

import pytest
from fault_machines import site_of
from rig.avr import whole
from rig.specs import changed, controller_of, sources_of
from suite import SEED, amount

from heatwright.sim.avr import AvrError
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.sim.faults import memory, starts
from heatwright.sim.faults.bounds import flash_s
from heatwright.sim.faults.site import OfState, Site
from heatwright.sim.faults.upsets import BAD, STATES, Upset, try_upset
from heatwright.spec.rules import RULES

DECIDING = ("chamber", "extruder", "fabricator", "kiln")
SAFETY = re.compile(r"(checks|clock|fault|flash|gate|guard_\w+|loop_\w+|main|output_\w+|relay)\.c")
"""The files whose functions decide about heat."""
CODES = {rule.id: code for code, rule in RULES.items()}
BOOT_BYTES = 512
CHECKED = {name: changed(name, ("safety:", "safety:\n  self_checks: true")) for name in DECIDING}
CHAMBER = CHECKED["chamber"]


def safety_bytes(site: Site, example: str) -> list[int]:
    """Return the addresses of what decides about heat."""
    texts = [text for name, text in sources_of(example).items() if SAFETY.fullmatch(name)]
    defined = {
        name
        for text in texts
        for name in re.findall(r"^[a-z][^;=\n]*?(\w+)\([^;\n]*\n\{", text, re.M)
    }
    functions = [each for each in site.program.functions if each.name in defined]
    assert len(functions) > 20
    return [place for each in functions for place in range(each.start, each.end)]


@pytest.mark.parametrize("example", DECIDING)
def test_a_flip_in_a_safety_function_is_found_in_a_round(example: str) -> None:
    """Told, or ended by a reset or by leaving what is simulated; and no heater is on then.

    But for one in a hundred: a flip in what calls the checks. One in a thousand is the aim.
    """
    site, missed = site_of(CHECKED[example]), []
    places, random = safety_bytes(site, CHECKED[example]), Random(f"flash {SEED} {example}")  # noqa: S311
    tried = amount("flash_flips")
    for _ in range(tried):
        place, bit = random.choice(places), random.randrange(8)
        state = random.choice([name for name in STATES if name != "off" or site.is_commanded])
        world = STATES[state](site)
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
    assert 100 * len(missed) <= max(100, tried), missed


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
    assert not {"flash.c", "checks.c"} & set(sources_of("chamber"))
    assert "FLASH" not in sources_of("chamber")["fault.h"]
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
    for _ in range(round(0.02 * avr.clock_hz)):
        if avr.program_counter == call:
            break
        avr.run_to(avr.cycle + 1)
    assert avr.program_counter == call
    avr.jump(behind)
    avr.run(0.03)
    assert device.read("fault.code") == CODES["sequence_broken"]
    assert not device.outputs["heater"].on


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


def test_a_main_loop_without_its_gate_is_told_and_lets_the_heater_go() -> None:
    """The interrupt comes and wakes the main loop, but nobody counts the permits any more."""
    clock = sources_of(CHAMBER)["clock.c"]
    deaf = whole(CHAMBER, changed={"clock.c": clock.replace("    gate_tick();\n", "")})
    device = AvrDevice(controller_of(CHAMBER), deaf)
    device.sense("air", 19.0)
    device.advance(1.0)
    assert device.read("fault.code") == CODES["sequence_broken"]
    assert not device.outputs["heater"].driven
