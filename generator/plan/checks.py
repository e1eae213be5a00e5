"""The self-checks of the controller: the main loop's permit is renewed only while all pass."""

from __future__ import annotations

from dataclasses import dataclass

from heatwright.generator.plan.adc import known_limits
from heatwright.generator.plan.core import WATCHDOG_NAMES
from heatwright.generator.plan.numbers import TICK_MS
from heatwright.generator.plan.parts import Call, Constant, File, Group, Part, Stage
from heatwright.generator.plan.source import Source
from heatwright.spec.self_checks import (
    FLASH_BYTES_A_TICK,
    measures_known_voltage,
    proves_watchdog,
    read_back,
    self_checked,
)

MOST_TICKS_WAITING = 10
WATCHDOG_MS = (12, 24)
"""Limits for the time of a watchdog set to 16 ms: hot, its oscillator is up to a fifth slower."""
PIN_HELD_TICKS = 3
NEAR_BYTES = 0x10000
"""Bytes of flash that a 16-bit address can reach."""


@dataclass(frozen=True, slots=True)
class CheckNames:
    """The values for the templates of the self-checks."""

    where: str
    adc: bool
    proves: bool
    far: bool
    loops: list[str]
    read_back: tuple[str, ...]
    pulses: bool
    watchdog: str
    released: list[str]


def plan_checks(root: Source) -> tuple[Part, ...]:
    """Plan the self-checks, if the controller has them."""
    if not self_checked(root.controller):
        return ()
    where = root.at("safety", "self_checks").where
    controller = root.controller
    lets_go = {controller.safety.relay, *(loop.heater for loop in controller.loops.values())}
    context = CheckNames(
        where=where,
        adc=measures_known_voltage(controller),
        proves=proves_watchdog(controller),
        far=controller.board.flash_bytes > NEAR_BYTES,
        loops=list(controller.loops),
        read_back=read_back(controller),
        pulses=any(controller.switches[name].is_windowed for name in read_back(controller)),
        watchdog=f"WDTO_{WATCHDOG_NAMES[controller.safety.watchdog_s]}",
        released=[name for name in controller.outputs if name in lets_go],
    )
    watchdog = (
        Constant(
            "WATCHDOG_LEAST",
            f"{10 * WATCHDOG_MS[0]}u",
            f"{where}: {WATCHDOG_MS[0]} ms, for a watchdog set to 16 ms",
        ),
        Constant("WATCHDOG_MOST", f"{10 * WATCHDOG_MS[1]}u", f"{where}: {WATCHDOG_MS[1]} ms"),
    )
    held = (
        Constant(
            "PIN_HELD_TICKS",
            f"{PIN_HELD_TICKS}u",
            f"{where}: one test may come just while the tick switches the pin",
        ),
    )
    names = ("checks.h", "checks.c", "cpu.c", "flash.h", "flash.c", "ram.h", "ram.c")
    return (
        Part(
            files=(
                File("seal.py", "project/seal.py"),
                *(File(f"src/{name}", f"self_checks/{name}.j2", context) for name in names),
            ),
            groups=(
                Group(
                    "Self-checks",
                    (
                        Constant(
                            "FLASH_BYTES_A_TICK",
                            f"{FLASH_BYTES_A_TICK}u",
                            f"{where}: {FLASH_BYTES_A_TICK * 1000 // TICK_MS} bytes per second",
                        ),
                        Constant(
                            "GUARD_JUDGED",
                            "2u",
                            f"{where}: second mark of a step, returned by its guard",
                        ),
                        *(watchdog if proves_watchdog(controller) else ()),
                        *known_limits(root),
                        *(held if read_back(controller) else ()),
                        Constant(
                            "CHECKS_MOST_TICKS",
                            f"{MOST_TICKS_WAITING}u",
                            f"{where}: most ticks that can wait (clock.c)",
                        ),
                    ),
                ),
            ),
            start_calls=(Call(Stage.GUARD, "checks.h", "checks_start();"),),
            tick_calls=(Call(Stage.GUARD, "checks.h", "checks_tick();"),),
        ),
    )
