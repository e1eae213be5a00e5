"""Faults and losses of power during a program: it must end or go on, as the spec says."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from heatwright.sim.faults import effects, starts
from heatwright.sim.faults.bounds import answer_s, watchdog_s
from heatwright.sim.faults.controller import memory
from heatwright.sim.faults.controller.processor import INTERRUPTS_ON, hang
from heatwright.sim.faults.effects import Heated
from heatwright.sim.faults.fault import Fault, Judge, Trip, nothing, tripping
from heatwright.sim.faults.machine import steady_c, watch_s
from heatwright.sim.faults.sensing.readings import SENSOR_RULES
from heatwright.sim.faults.site import LATCHED, Place
from heatwright.sim.faults.world import STEP_S, Site, World
from heatwright.sim.plants import plant_of
from heatwright.sim.reference.programs.state import (
    FAILED,
    IDLE,
    INTERRUPTED,
    PAUSED,
    RETURNING,
    RUNNING,
    TOO_FAR,
)
from heatwright.spec import RULES, HoldBack, Programs, Segment, facts_of
from heatwright.spec.programs import AfterPowerLoss

LAGS = "program_lags"

UNDER_WAY_S = 90.0
"""How long the program runs before the fault: longer than the usual time between two saves."""
WATCH_S = 30.0
"""Longer than an operator needs for a command at the keypad or the touch display."""
FAR_K = 5.0
"""During a loss of power the machine cools by this much more than a resumption allows."""
COOLING_S = 4 * 3600.0
LOOK_STEPS = 3
BELOW_TARGET_K = 20.0
"""A weak heater levels out this far below the first segment's target."""


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of a loop that has programs, if at least one is stored."""
    programs = site.controller.programs
    if programs is None or not site.facts.programmed or not programs.stored:
        return
    no_reading = Trip(SENSOR_RULES, answer_s(site.loop))
    lost = tripping(site, "sensor_lost_in_program", memory.cut_line, no_reading, memory.mend_line)
    lost = replace(lost, make=lambda: under_way(site), sensor_lies=True, judge=_judge(programs))
    yield lost
    reset = Trip(("watchdog_reset",), watchdog_s(site))
    hung = tripping(site, "hung_in_program", partial(hang, entry=INTERRUPTS_ON), reset)
    yield replace(hung, make=lambda: under_way(site), judge=_judge(programs))
    flipped = Trip(("memory_damaged",), site.loop.periods_s(2))
    yield replace(lost, id="program_flipped", cause=_flip, cure=nothing, trip=flipped,
                  sensor_lies=False, judge=_failed)  # fmt: skip
    if programs.on_fault == "pause":
        name = "power_cut_in_interrupted_program"
        yield replace(lost, id=name, cause=_cut_while_latched, cure=nothing)
    yield from _lagging(site, programs)
    yield from _power_cuts(site, programs)


def shows_s(site: Site) -> float:
    """Return the longest time until a command, or a start-up, changes the program's state, s.

    Only a step with a reading takes a command: it may be a whole period away.
    """
    return WATCH_S + site.loop.periods_s(starts.FIRST_STEPS)


def under_way(site: Site) -> World:
    """Return a world in which the first program has run for a while."""
    world = _started(site)
    world.run(UNDER_WAY_S)
    return world


def first_segments(site: Place) -> Sequence[Segment]:
    """Return the segments of the first stored program, if the loop has one."""
    programs = site.controller.programs
    has = programs is not None and site.facts.programmed and programs.stored
    return programs.stored[0].segments if programs is not None and has else ()


def in_segment(site: Site, number: int) -> World:
    """Return a world whose first program has just come to a segment; they count from 1."""
    before = first_segments(site)[: number - 1]
    targets_c = [site.ambient_c, *(each.to_c for each in before if each.to_c is not None)]
    world = _started_at(site, targets_c[-1])
    if number > 1:
        world.device.program("jump", number)
        world.until(lambda now: _program(now, "segment") == number, shows_s(site))
    return world


def _started(site: Site) -> World:
    return _started_at(site, site.ambient_c)


def _started_at(site: Site, start_c: float) -> World:
    world = starts.begun(site, start_c)
    world.device.program("start", 1)
    world.until(lambda now: _program(now, "state") == RUNNING, shows_s(site))
    return world


def _flip(world: World) -> None:
    """Flip a bit in the copy of the program that runs."""
    memory.flip(world, "program.c:loaded", memory.HIGHEST_BIT, byte=-1)


def _program(world: World, member: str) -> Any:
    return world.device.read(f"program.{member}").item()


def _failed(world: World) -> str:
    """Check that the program has ended, and that the heater is off after the acknowledgement."""
    if (_program(world, "state"), _program(world, "ended")) != (IDLE, FAILED):
        return f"the program is in state {_program(world, 'state')}, not ended by the fault"
    began_s = world.now_s
    world.run(shows_s(world.site))
    return "" if world.heater.last_on_s(began_s) is None else "heater on after the program's end"


def _judge(programs: Programs) -> Judge:
    if programs.on_fault == "stop":
        return _failed
    return lambda world: _kept(world, programs)


def _kept(world: World, programs: Programs) -> str:
    """Check that the program waits for an operator with the heater off, then goes on as it must."""
    state, *place = _place(world)
    if state != INTERRUPTED:
        return f"the program is in state {state}, not interrupted by the fault"
    began_s, closed = world.now_s, _relay_closed_cycles(world)
    world.run(shows_s(world.site))
    if world.heater.last_on_s(began_s) is not None:
        return "the heater is on while the program is interrupted"
    if _relay_closed_cycles(world) != closed:
        return "the safety relay closed while the program is interrupted"
    if _place(world) != [INTERRUPTED, *place]:
        return f"the interrupted program moved from {place} to {_place(world)}"
    wanted = _resumes_to(world, programs.after_power_loss)
    world.device.program("resume")
    world.until(lambda now: _program(now, "state") != INTERRUPTED, shows_s(world.site))
    state, *now = _place(world)
    if state not in wanted:
        return f"the resumed program is in state {state}, not one of {wanted}"
    moved = state == RUNNING  # a running program may have moved by a step
    return "" if moved or now == place else f"the program resumed at {now}, not {place}"


def _relay_closed_cycles(world: World) -> int:
    """Return how long the safety relay was closed, in cycles; 0 if another loop may close it."""
    controller, relay = world.site.controller, world.device.relay
    others_rest = all(
        facts_of(controller, name).switched and not world.device.read(f"loop_{name}.enabled")
        for name in controller.loops
        if name != world.site.loop_name
    )
    return relay.wired.closed_cycles if relay is not None and others_rest else 0


def _resumes_to(world: World, after: AfterPowerLoss) -> tuple[int, ...]:
    """Return the states that may follow a resumption."""
    if _is_within(after, world.loop("temperature_c") - _program(world, "before_c")):
        return RETURNING, RUNNING
    return (PAUSED if after.otherwise == "pause" else IDLE,)


def _is_within(after: AfterPowerLoss, gone_k: float) -> bool:
    """Whether a program resumes although the temperature has changed so far, K."""
    return after.resume_within_k > 0 and bool(abs(gone_k) <= after.resume_within_k)


def _place(world: World) -> list[Any]:
    """Return the program's state and position."""
    members = ("state", "number", "segment", "elapsed", "clock", "segment_clock", "setpoint_c")
    return [_program(world, member) for member in members]


def _cut_while_latched(world: World) -> None:
    """Cut the sensor off until a fault is latched, repair it, then cut the power."""
    memory.cut_line(world)
    world.until(LATCHED, answer_s(world.site.loop))
    world.run(shows_s(world.site))
    memory.mend_line(world)
    world.power_cut()


# -- a machine that lags ---------------------------------------------------------------------


def _lagging(site: Site, programs: Programs) -> Iterator[Fault]:
    """Yield a heater that is too weak for the first ramp, but still raises the temperature."""
    hold_back, first = programs.hold_back, programs.stored[0].segments[0]
    ramp_s = _ramp_s(site, first)
    if hold_back is None or ramp_s is None or first.to_c is None:
        return
    share = _share_for(site, first.to_c - BELOW_TARGET_K)
    weak = Heated(site.loop.heater, effects.weakened(share))
    yield Fault(
        "heater_too_weak_for_program",
        lambda: _started(site),
        weak,
        weak.mend,
        watch_s=ramp_s + hold_back.limit_s + watch_s(site),
        judge=lambda world: _lag_was_long(world, programs, hold_back),
    )


def _ramp_s(site: Site, segment: Segment) -> float | None:
    """Return how long the first ramp lasts from the ambient temperature, s; None: no ramp."""
    if segment.over_s is not None:
        return segment.over_s
    if segment.at_k_per_h is None or segment.to_c is None:
        return None
    return abs(segment.to_c - site.ambient_c) / segment.at_k_per_h * 3600.0


def _share_for(site: Site, level_c: float) -> float:
    """Return the share of full power that holds a temperature, °C, found by bisection."""
    low, high = 0.0, 1.0
    for _ in range(20):
        middle = (low + high) / 2
        if steady_c(site, middle, ambient_c=site.ambient_c) < level_c:
            low = middle
        else:
            high = middle
    return low


def _lag_was_long(world: World, programs: Programs, hold_back: HoldBack) -> str:
    """Check that program_lags did not trip too early, and what the program did after the trip."""
    lags = [trip for trip in world.trips.since(0.0) if RULES[trip.code].id == LAGS]
    early = bool(lags) and lags[0].time_s < hold_back.limit_s
    return "program_lags tripped too early" if early else _judge(programs)(world)


# -- losses of power -------------------------------------------------------------------------


def _power_cuts(site: Site, programs: Programs) -> Iterator[Fault]:
    stops = _stays_paused if programs.after_power_loss.otherwise == "pause" else _stays_ended
    again = Fault(
        "power_cut_in_program",
        lambda: under_way(site),
        lambda world: world.power_cut(),
        calm=True,
        watch_s=shows_s(site),
        judge=lambda world: (
            _resumed_as_saved(world, programs) if _is_near(world, programs) else stops(world)
        ),
    )
    yield again
    hot, cools = partial(_hot, site, programs), partial(_cut_until_cold, programs=programs)
    yield replace(again, id="power_cut_until_cold", make=hot, cause=cools, judge=stops)
    yield replace(again, id="power_cut_in_pause", make=lambda: paused(site), judge=_stays_paused)


def _hot(site: Site, programs: Programs) -> World:
    """Return a world with a program, so hot that it can cool more than a resumption allows."""
    resumes_within_k = programs.after_power_loss.resume_within_k
    world = _started_at(site, site.ambient_c + resumes_within_k + 4 * FAR_K)
    world.run(WATCH_S)
    return world


def paused(site: Site) -> World:
    """Return a world whose first program an operator has paused."""
    world = under_way(site)
    world.device.program("pause")
    world.until(lambda now: _program(now, "state") == PAUSED, shows_s(site))
    world.run(site.loop.periods_s(LOOK_STEPS))
    return world


def _cut_until_cold(world: World, programs: Programs) -> None:
    """Cut the power until the machine is colder than a resumption allows."""
    cold_c = world.sensed_c - programs.after_power_loss.resume_within_k - FAR_K
    world.power_cut(_cools_in_s(world, cold_c))


def _cools_in_s(world: World, cold_c: float) -> float:
    """Return how long the machine takes to cool with all outputs off, s."""
    site = world.site
    lag = site.network.model_copy(update={"initial_c": world.sensed_c})
    plant = plant_of(site.controller, lag, ambient_c=world.ambient_c, step_s=STEP_S)
    off = dict.fromkeys(site.controller.outputs, 0.0)
    for row in range(round(COOLING_S / STEP_S)):
        if plant.sensed_c()[site.loop.sensor] <= cold_c:
            return row * STEP_S
        plant.step(off)
    return COOLING_S


def _is_near(world: World, programs: Programs) -> bool:
    """Whether the first reading after the loss of power is near the one at the last save.

    After that save the program has run for up to `save_every`, in which a cold machine warms up.
    """
    log = world.device.steps(world.site.loop_name)
    after = log[(log["time_s"] > world.power_on_s) & (log["reading_status"] == 0)]
    if not len(after):
        return False
    single = "reading_c" if "reading_c" in (log.dtype.names or ()) else "temperature_c"
    gone_k = after[0][single] - after[0]["program.before_c"]
    return _is_within(programs.after_power_loss, gone_k)


def _resumed_as_saved(world: World, programs: Programs) -> str:
    """Check that the program goes on where it was last saved, after a valid reading."""
    state, segment = _program(world, "state"), _program(world, "segment")
    if state not in (RUNNING, RETURNING) or segment != 1 or _program(world, "number") != 1:
        return f"after the loss of power the program is in state {state}, segment {segment}"
    loop = world.site.loop
    run_s = loop.periods_s(_program(world, "clock"))
    least_s = UNDER_WAY_S - programs.save_every_s - loop.periods_s(1)
    if not least_s <= run_s <= UNDER_WAY_S + 2 * shows_s(world.site):
        return f"the program resumed {run_s:g} s after its start, not where it was saved"
    return _read_first(world)


def _read_first(world: World) -> str:
    """Check that no heater was on before the first valid reading after the power came back."""
    log = world.device.steps(world.site.loop_name)
    valid = log[(log["time_s"] > world.power_on_s) & (log["reading_status"] == 0)]
    first_s = float(valid["time_s"][0]) if len(valid) else float("inf")
    world.device.feed()
    on_s = world.heater.first_on_s
    early = on_s is not None and on_s < first_s
    return "the heater was on before a valid reading" if early else ""


def _stays_ended(world: World) -> str:
    ended = (_program(world, "state"), _program(world, "ended"))
    if ended != (IDLE, TOO_FAR):
        return f"after the loss of power the program is in state {ended[0]}, ended {ended[1]}"
    return _never_on(world)


def _stays_paused(world: World) -> str:
    state = _program(world, "state")
    return _never_on(world) if state == PAUSED else f"program in state {state}, not paused"


def _never_on(world: World) -> str:
    on_s = world.heater.last_on_s(world.power_on_s)
    return "" if on_s is None else f"the heater was on at {on_s:.3f} s, after power-on"
