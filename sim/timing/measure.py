"""The measurement: a quiet run to plan the keys, then ten minutes of keys, display and line."""

from pathlib import Path

import numpy as np

from heatwright.sim.avr import Avr
from heatwright.sim.bench import Progress
from heatwright.sim.binary.elf import Elf
from heatwright.sim.binary.profile import Profile
from heatwright.sim.device import PROOF, AvrDevice
from heatwright.sim.timing import steps, waits
from heatwright.sim.timing.display import StartUps, button_to_display, to_come
from heatwright.sim.timing.figures import JITTER_US, Figure, Timing
from heatwright.sim.timing.operator import HELD_S, Press, aimed, presses
from heatwright.sim.timing.stage import Stage
from heatwright.spec import Controller, facts_of, longest_wait_s

LEAST_S = 600.0
"""Time that is measured: twenty start-ups of the display, each with a key at another phase."""
LEAST_STEPS = 5
"""A slow loop that makes fewer steps in that time is measured for longer."""
QUIET_S = 95.0
"""In this time the display starts up often enough to predict its next start-ups."""
START_S = 1.0
"""Main begins within this time."""


def measure(
    controller: Controller,
    elf: Path | str | Elf,
    *,
    static_stack_bytes: int | None = None,
    progress: Progress | None = None,
) -> Timing:
    """Measure an unmodified binary.

    Code before main, such as the clearing of RAM, is not measured, and neither is the start-up that
    ends with the watchdog's reset, because no interrupt or display waits then.

    static_stack_bytes -- worst case from the code's analysis, which the used stack must not exceed.

    Raises what AvrDevice does.
    """
    program = elf if isinstance(elf, Elf) else Elf(elf)
    pressed = _planned(controller, program)
    device = AvrDevice(controller, program)
    stage = Stage(controller, device, _length_s(controller))
    _to_main(device.avr, program)
    profile = device.avr.profile(program)
    steps.trace(profile, program, list(controller.loops))
    _play(stage, device, pressed, _length_s(controller), progress)
    files = waits.Files(program)
    found = _figures(controller, device, profile, files)
    if facts_of(controller).keypad is not None:
        answer = button_to_display(pressed, device.shield.lcd.history)
        found = {"button_to_display_ms": answer, **found}
    if static_stack_bytes is not None:
        found["stack_used_bytes"] = waits.stack(profile.stack_used, static_stack_bytes)
    return Timing(
        figures=found,
        functions=waits.costs(profile, files, device.avr.cycle),
        idle_fraction=device.avr.sleep_cycles / device.avr.cycle,
        seconds=device.time_s,
    )


def _length_s(controller: Controller) -> float:
    return max(LEAST_S, LEAST_STEPS * controller.longest_period_s)


def _planned(controller: Controller, program: Elf) -> list[Press]:
    """Watch the program without keys, then time the keys to coincide with its actions."""
    keypad = facts_of(controller).keypad
    if keypad is None:
        return []
    device = AvrDevice(controller, program)
    start_ups = StartUps(controller.board)
    device.record(start_ups)
    length_s = _length_s(controller)
    Stage(controller, device, length_s).advance(QUIET_S)
    device.feed()
    made_s = device.steps(keypad.loop)["time_s"].tolist()
    times_s = aimed(length_s, to_come(made_s, length_s), to_come(start_ups.times_s(), length_s))
    return presses(controller, keypad, times_s)


def _to_main(avr: Avr, program: Elf) -> None:
    """Run until main begins, after the watchdog's reset if there is one."""
    main = program.function("main")
    end = round(START_S * avr.clock_hz)
    for _ in range(1 + any(each.name == PROOF for each in program.functions)):
        avr.run_to_code(main, end)


def _play(
    stage: Stage, device: AvrDevice, pressed: list[Press], until_s: float, progress: Progress | None
) -> None:
    for press in pressed:
        stage.advance(press.time_s)
        device.press(press.key)
        stage.advance(press.time_s + HELD_S)
        device.press(None)
        if progress is not None:
            progress(press.time_s, until_s)
    stage.advance(until_s)


def _figures(
    controller: Controller, device: AvrDevice, profile: Profile, files: waits.Files
) -> dict[str, Figure]:
    program, clock_hz = device.elf, device.avr.clock_hz
    each = [
        steps.jitter(
            profile.entries(steps.STEP.format(loop=name)),
            loop.period_s,
            clock_hz,
            name,
            len(controller.loops) * JITTER_US,
        )
        for name, loop in controller.loops.items()
    ]
    wakes = [profile.entries(handler) for handler in steps.handlers(program)]
    return {
        "step_jitter_us": max(each, key=lambda one: one.worst or np.inf),
        "longest_busy_wait_us": waits.busy(profile, files),
        **waits.masked(profile, files, clock_hz, 1e6 * longest_wait_s(controller)),
        "longest_tick_us": steps.longest_tick(
            profile.entries(steps.TICK),
            profile.entries(steps.WAIT),
            np.sort(np.concatenate(wakes)),
            clock_hz,
        ),
    }
