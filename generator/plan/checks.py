"""The self-checks of the controller: the main loop's permit is renewed only while all pass."""

from collections.abc import Iterator
from dataclasses import dataclass

from heatwright.generator.plan.adc import known_limits
from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.generator.plan.numbers import TICK_MS
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec import facts_of
from heatwright.spec.self_checks import FLASH_BYTES_A_TICK

MOST_TICKS_WAITING = 10
WATCHDOG_MS = (12, 24)
"""Limits for the time of a watchdog set to 16 ms; a hot oscillator is up to a fifth slower."""
PIN_HELD_TICKS = 3
NEAR_BYTES = 0x10000
"""Bytes of flash that a 16-bit address can reach."""


@dataclass(frozen=True, slots=True)
class CheckNames:
    """The values for the templates of the self-checks.

    proves -- the watchdog is tested at each start; far -- the flash needs addresses of more than 16
    bits; read_back -- the outputs whose pins are compared with their levels; pulses -- one of them
    is switched on and off within a window.
    """

    where: str
    adc: bool
    proves: bool
    far: bool
    loops: list[str]
    read_back: tuple[str, ...]
    pulses: bool
    watchdog: str


def plan_checks(root: Source) -> tuple[Part, ...]:
    """Plan the self-checks, if the controller has them."""
    controller, facts = root.controller, facts_of(root.controller)
    if not facts.checked:
        return ()
    context = CheckNames(
        where=root.at("safety", "self_checks").where,
        adc=facts.measures_known_voltage,
        proves=facts.proves_watchdog,
        far=controller.board.flash_bytes > NEAR_BYTES,
        loops=list(controller.loops),
        read_back=facts.read_back,
        pulses=any(controller.switches[name].is_windowed for name in facts.read_back),
        watchdog=f"WDTO_{WATCHDOG_NAMES[controller.safety.watchdog_s]}",
    )
    names = ("checks.h", "checks.c", "cpu.c", "flash.h", "flash.c", "ram.h", "ram.c")
    return (
        Part(
            files=(
                File("seal.py", "project/seal.py"),
                *(File(f"src/{name}", f"self_checks/{name}.j2", context) for name in names),
            ),
            groups=(Group("Self-checks", tuple(_constants(root))),),
            start_calls=(Call(Stage.GUARD, "checks.h", "checks_start();"),),
            tick_calls=(Call(Stage.GUARD, "checks.h", "checks_tick();"),),
        ),
    )


def _constants(root: Source) -> Iterator[Constant]:
    at, (least_ms, most_ms) = root.at("safety", "self_checks"), WATCHDOG_MS
    speed = f"{FLASH_BYTES_A_TICK * 1000 // TICK_MS} bytes per second"
    yield at.count("FLASH_BYTES_A_TICK", FLASH_BYTES_A_TICK, speed)
    if facts_of(root.controller).proves_watchdog:
        told = f"{least_ms} ms, for a watchdog set to 16 ms"
        yield at.count("WATCHDOG_LEAST", 10 * least_ms, told)
        yield at.count("WATCHDOG_MOST", 10 * most_ms, f"{most_ms} ms")
    yield from known_limits(root)
    why = "one test may come just while the tick switches the pin"
    yield at.count("PIN_HELD_TICKS", PIN_HELD_TICKS, why)
    yield at.count("CHECKS_MOST_TICKS", MOST_TICKS_WAITING, "most ticks that can wait (clock.c)")
