"""The outputs' C, gate, relay and reset before the mutation engine, each judged on a board."""

from collections.abc import Callable, Iterator
from functools import partial

import host_specs
import test_outputs_gate as gate
import test_outputs_relay_whole as hosted
import test_outputs_ticks as ticks
from rig.firmware import Firmware, Program, spec_of
from rig.outputs import Wired, cause_problem, reset_problem
from test_outputs_pwm import PwmBoard, heater_problems, placed, restart_problem

from heatwright.sim.binary.elf import Elf
from heatwright.sim.device import AvrDevice
from heatwright.sim.native.relay import Armature

Check = Callable[[Wired, Elf], object]


def arena(name: str, place: Wired, broken: tuple[str, ...], *checks: Check) -> Firmware:
    bound = tuple(partial(check, place) for check in checks)
    return Firmware(f"outputs/{name}", place.program, broken, bound)


def pwm_problem(place: Wired, elf: Elf) -> str:
    return next(filter(None, heater_problems(place, elf)), "")


def off_problem(place: Wired, elf: Elf) -> str:
    bench = PwmBoard(place, elf)
    return reset_problem(bench, "heater") or restart_problem(bench)


def relay_off_problem(place: Wired, elf: Elf) -> str:
    bench = gate.RelayBoard(place, elf)
    return reset_problem(bench, "contactor") or reset_problem(bench, "heater")


def feed_problems() -> Iterator[Check]:
    for test in (
        ticks.test_the_motor_is_let_go,
        ticks.test_a_fault_stops_it_at_once,
        ticks.test_moves_the_same_way_are_one,
        ticks.test_it_waits_for_the_heat_and_goes_on,
        ticks.test_a_stop_slows_down_and_forgets,
        ticks.test_speed_changes_by_no_more_than_the_acceleration,
        ticks.test_it_goes_along_a_trapezoid,
        partial(ticks.test_any_speed_is_right_in_the_mean, mm_per_s=0.0001),
        partial(ticks.test_any_speed_is_right_in_the_mean, mm_per_s=17.77),
        ticks.test_every_step_is_made,
    ):
        yield lambda place, elf, test=test: test(ticks.Feed(place, elf))


TOUCHED = host_specs.TEXTS["touched"]
"""A loop that a display switches, with a relay: here the sensor and the relay are there."""


def loop_problem(elf: Elf) -> str:
    device = AvrDevice(spec_of(TOUCHED).controller, elf)
    relay = device.relay
    assert relay is not None
    device.sense("air", 20.0)
    device.advance(5.0)
    if device.steps("air")["reading_status"].any():
        return "not a reading in each step, from the first on"
    for order, closed in (("", False), ("#2 1;", True), ("#2 0;", False), ("#2 1;", True)):
        device.send(order)
        device.advance(device.time_s + 3.0)
        if relay.closed != closed:
            return f"the relay is not {'closed' if closed else 'open'} behind {order!r}"
    device.on_fraction("heater")
    device.advance(device.time_s + 3.0)
    if not device.on_fraction("heater"):
        return "the heater is off"
    relay.fail(Armature.DEAD)
    device.advance(device.time_s + 3.0)
    return "" if device.read("fault.code") == gate.OPEN else "it is not found to be open"


TWO_LOOPS = hosted.SPEC % ""


def two_loops_problem(elf: Elf) -> None:
    hosted.test_it_is_closed_while_a_loop_is_on(hosted.powered(TWO_LOOPS, elf))


HEATER = ("output_heater",)
BOTH = ("output_heater", "output_cooler", "gate")
ARENAS = [
    arena("relay", gate.relayed(), ("relay", "gate", "reset"), gate.whole_problem,
          relay_off_problem, cause_problem),
    arena("relay without contact", gate.relayed(feedback=False), ("relay", "gate"),
          gate.whole_problem),
    arena("held", gate.held(*gate.VARIANTS["all"]), BOTH, gate.any_orders_problem),
    arena("switched", gate.held(), BOTH, gate.any_orders_problem),
    arena("pwm beside a cooler", gate.held(kind="pwm"), HEATER, gate.timed_problem),
    arena("windows beside a cooler", gate.held(kind="windows"), HEATER, gate.timed_problem),
    Firmware("outputs/relay of two loops", Program(TWO_LOOPS), ("gate",), (two_loops_problem,)),
    Firmware("outputs/relay of a loop", Program(TOUCHED), ("loop_air",), (loop_problem,)),
    *(
        arena(f"pwm by {by}", placed("uno", {"heater": f"{said}, power: 40 W"}),
              ("output_heater", "reset"), off_problem, cause_problem, pwm_problem)
        for by, said in (
            ("interrupts", "D4, frequency: 490 Hz"), ("timer", "D3, frequency: 976.5625 Hz"),
        )
    ),
    arena("spread", ticks.windows(ticks.SPREAD, "low"), HEATER, ticks.whole_problem),
    arena("burst", ticks.windows(ticks.SHORT_LEFT_OUT, "low"), HEATER, ticks.whole_problem),
    arena("feed", ticks.fed("nano"), ("output_feed",), *feed_problems()),
]  # fmt: skip
