"""Several loops: the model of all of them does, bit for bit, what the binary does; and a healthy
machine that another loop warms, or whose setpoint is raised while it cools."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from machines import at, course, events
from matplotlib.colors import to_hex
from rig.bad_specs import bases
from rig.controllers import LENGTH_S, drawings
from rig.firmware import began_s, changed, controller_of, device_of, spec_of, whole
from suite import SEED, amount

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.plots.plot import run_figure
from heatwright.sim.plots.plot_data import all_faults
from heatwright.sim.reference.protection.rules import RUNAWAY_BELOW
from heatwright.sim.replay import replay_all
from heatwright.sim.trace import StepLog
from heatwright.spec import Controller
from heatwright.spec.base import ReadOnlyDict

TOOLS = (Path(__file__).parent / "several_loops.yaml").read_text("utf-8")
SPECS = {"barrel": "barrel", "tools": TOOLS}
FELT = {"barrel": {"barrel": 20.0, "die": 20.0}, "tools": {"near": 25.0, "middle": 25.0, "far": 25}}
DONE = {
    # What a sensor feels from a time on, and what is written or sent then.
    "barrel": (
        (2.3, {"barrel.setpoint": 200.0, "barrel.enabled": True, "die.enabled": True}),
        (5.3, ("barrel", 24.0)), (8.3, ("die", 23.0)),
        (10.3, ("die", 60.0)),  # a jump, which ends the heating of both
        (13.6, {"acknowledge": True}), (14.6, {"barrel.enabled": True}),
        (18.6, {"die.setpoint": 150.0}), (21.6, {"barrel.kp": 3.0, "die.ki": 0.5}),
        (24.4, {"die.enabled": True, "barrel.enabled": False}),
    ),
    "tools": (
        (1.23, "M104 S40"), (2.23, "M104 T1 S60"), (3.23, "T1"), (4.23, "M104 S50"),
        (5.23, "M104 E2 S45"), (6.23, "M301 P3"), (7.23, "M301 T0 I0.1 D5"), (8.23, "T7"),
        (9.23, "M104 T7 S90"), (10.23, "M104 D20"), (11.23, "M104 T2 D20"),
        (12.23, ("far", 28.0)), (13.73, ("middle", 60.0)),  # a jump, again
        (15.23, "M104 T2 S45"), (17.23, "M999"), (19.23, "M104 T2 S45"),
        (23.23, "T0"), (24.23, "M104 S40"), (26.26, "M112"), (27.23, "M999"),
    ),
}  # fmt: skip
END_S = 30.3


def driven(device, name, began_s=0.0):
    """Let a device do what DONE has, without a machine, from its first tick on: its logs."""
    for sensor, felt in FELT[name].items():
        device.sense(sensor, felt)
    for time_s, what in DONE[name]:
        device.advance(began_s + time_s)
        if isinstance(what, dict):
            for value in what.items():
                device.write(*value)
        elif isinstance(what, tuple):
            device.sense(*what)
        else:
            device.send(what)
    device.advance(began_s + END_S)
    return {loop: device.steps(loop) for loop in controller_of(SPECS[name]).loops}


@cache
def modelled(name):
    return driven(ReferenceDevice(controller_of(SPECS[name])), name)


@pytest.mark.parametrize("name", SPECS)
def test_the_model_of_all_loops_does_what_the_binary_does(name):
    device = device_of(SPECS[name])
    logs = driven(device, name, began_s(SPECS[name]))
    for loop, expected in modelled(name).items():
        found = logs[loop]
        assert len(found) == len(expected)
        for member in set(expected.dtype.names) - {"time_s"}:
            differ = np.flatnonzero(
                found[member].copy().view("u1") != expected[member].copy().view("u1")
            )
            assert not len(differ), f"{loop}: {member} in step {differ[0]}"


def test_a_fault_of_one_stops_all_and_each_goes_on_by_itself():
    logs = modelled("barrel")
    assert course(logs["barrel"], "fault.code", "enabled") == [
        (0, 0), (0, 1), (8, 1), (0, 0), (0, 1), (0, 0),
    ]  # fmt: skip
    assert course(logs["die"], "fault.code", "enabled") == [
        (0, 0), (0, 1), (8, 1), (0, 0), (0, 1),
    ]  # fmt: skip
    near, middle, far = modelled("tools").values()
    assert course(near, "setpoint_c", "fault.code")[-4:] == [(0, 0), (40, 0), (40, 19), (0, 0)]
    assert course(middle, "setpoint_c", "mode") == [(0, 0), (60, 0), (50, 0), (50, 1), (0, 0)]
    assert set(far["setpoint_c"]) == {0, 45}


def test_a_line_goes_to_the_host_beside_a_display_and_an_order_to_the_display():
    text = changed(
        changed("printer").partition("simulation:")[0], (", B: bed", ""),
        ("interfaces:\n", "interfaces:\n  - {kind: nextion, loop: bed, baud: 9600, port: 1}\n"),
        ("initial: 0 °C, minimum: 0 °C, maximum: 110 °C",
         "initial: 40 °C, minimum: 40 °C, maximum: 110 °C"),
        ("    autotune: {cycles: 5, swing: 100 %}\n    protection:\n      maximum: 125",
         "    protection:\n      maximum: 125"),
    )  # fmt: skip
    controller = controller_of(text)
    for device in (ReferenceDevice(controller), AvrDevice(controller, whole(text))):
        for sensor in controller.thermometers:
            device.sense(sensor, 25.0)
        device.advance(1.23)
        for line in ("M104 S200", "#3 60;", "#2 1;"):
            device.send(line)
        device.advance(4.0)
        told = {loop: device.steps(loop)[-1]["setpoint_c"] for loop in controller.loops}
        assert told == {"hotend": 200.0, "bed": 60.0}


@pytest.mark.parametrize(("jumps_after_s", "latched"), [(20.0, 0), (0.0, 0), (0.0, 8)])
def test_a_fault_that_comes_and_goes_between_two_steps_of_another_loop(jumps_after_s, latched):
    """Or before its first one; and whether one has come anew by then."""
    controller = controller_of("barrel")
    slow = controller.loops["die"].model_copy(update={"period_s": 20.0})
    controller = controller.with_loop("die", slow)
    device = ReferenceDevice(controller)
    for sensor in controller.thermometers:
        device.sense(sensor, 20.0)
    device.advance(jumps_after_s + 4.3)
    device.sense("barrel", 60.0)  # a jump
    device.advance(jumps_after_s + 8.3)
    device.write("acknowledge", True)
    device.advance(jumps_after_s + 12.3)
    if latched:
        device.sense("barrel", 20.0)
    device.advance(jumps_after_s + 30.3)
    logs = {loop: device.steps(loop) for loop in controller.loops}
    assert set(logs["die"]["fault.code"]) == {latched}
    assert logs["die"]["fault.temperature_c"][-1] > 0
    assert [each.first for each in replay_all(controller, logs).values()] == [(), ()]


@pytest.mark.parametrize("number", range(amount("drawn_models")))
def test_any_number_of_loops_is_modelled(number):
    """The faults of each stop the others, as the replay of a binary has it."""
    random = Random(f"models {SEED} {number}")  # noqa: S311 - no secret
    drawn = next(each for each in drawings(random, (2, 3)) if each.spec.controller.simulation)
    controller = drawn.spec.controller
    logs = bench(controller, ReferenceDevice(controller)).steps
    for name, log in logs.items():
        assert abs(len(log) - LENGTH_S / controller.loops[name].period_s) <= 1, drawn
    found = replay_all(controller, {name: log for name, log in logs.items() if len(log)})
    assert [each.first for each in found.values() if each.mismatches or each.restored] == [], drawn


def test_a_picture_has_a_colour_for_each_loop_one_legend_and_a_fault_once():
    controller = controller_of(TOOLS)
    device = ReferenceDevice(controller)
    told = at({1: "M104 S60", 2: "M104 T1 S40", 3: "M104 T2 S30", 13.3: "M112"})
    trace = bench(controller, device, events(*told, {"for": "20 s"}))
    assert [code for _, code in all_faults(trace)] == [19]
    panels = run_figure(trace, controller).axes
    assert [panel.get_legend() is not None for panel in panels] == [True] + 6 * [False]
    colours = {}
    for loop, closer, duty in zip(controller.loops, panels[1::2], panels[2::2], strict=True):
        lines = [line for line in closer.lines if len(line.get_xdata()) > 2]  # not the fault's
        (colours[loop],) = {line.get_color() for line in lines}
        assert {line.get_linestyle() for line in lines} == {"-", "--"}
        assert to_hex(duty.collections[0].get_facecolor()[0]) == colours[loop]
    assert len({*colours.values()}) == 3
    texts = {text.get_text() for text in panels[0].get_legend().get_texts()}
    assert {"near reading", "near setpoint", "far setpoint", "frame"} <= texts


TWO_ZONES = """
heatwright: 1
controller: {name: rollers, board: mega2560}
sensors: {upper: {kind: ds18b20, pin: D22}, lower: {kind: ds18b20, pin: D23}}
outputs:
  upper_heater: {kind: time_proportional, pin: D30, window: 2 s, power: 150 W}
  lower_heater: {kind: time_proportional, pin: D31, window: 2 s, power: 150 W}
loops:
  upper: {sensor: upper, heater: upper_heater, period: 1 s,
    setpoint: {initial: 100 °C, minimum: 40 °C, maximum: 100 °C},
    algorithm: {kind: pid, kp: 10, ki: 0.05}}
  lower: {sensor: lower, heater: lower_heater, period: 1 s,
    setpoint: {initial: 40 °C, minimum: 40 °C, maximum: 100 °C},
    algorithm: {kind: pid, kp: 10, ki: 0.05}}
interfaces: [{kind: serial_plotter, loop: upper, baud: 9600}]
simulation:
  ambient: 20 °C
  plant:
    kind: thermal_network
    nodes: {upper: 500 J/K, lower: 500 J/K}
    links:
      - {between: [upper, lower], resistance: 1 K/W}
      - {between: [upper, ambient], resistance: 1.2 K/W}
      - {between: [lower, ambient], resistance: 1.2 K/W}
    heat: {upper_heater: upper, lower_heater: lower}
    sense: {upper: {node: upper, lag: 3 s}, lower: {node: lower, lag: 3 s}}
  scenario: [{for: 40 min}]
"""


def with_old_rules(controller: Controller) -> Controller:
    """Give all rules the numbers that they have where no plant is given."""
    loops = {}
    for name, loop in controller.loops.items():
        rules = {
            rule: type(limits)()
            for rule in ("heating", "frozen", "runaway", "rising_while_off")
            if (limits := getattr(loop.protection, rule)).derived
        }
        protection = loop.protection.model_copy(update=rules)
        loops[name] = loop.model_copy(update={"protection": protection})
    return controller.model_copy(update={"loops": ReadOnlyDict(loops)})


def test_what_the_plant_says_does_not_trip_in_health() -> None:
    """Where nothing is known of the plant, the rules count any rise of one that another warms."""
    spec = spec_of(TWO_ZONES).controller
    for machine, expected in ((spec, {0}), (with_old_rules(spec), {11, 13})):
        log = bench(machine, ReferenceDevice(machine), step_s=1.0).steps["lower"]
        assert log["fault.code"].max() in expected


COOLING = changed(
    bases()["simulated_pid_oven"],
    (
        "simulation:\n",
        "    protection: {runaway: {below: 12 K, for: 63 s}}\n"
        "interfaces: [{kind: modbus_rtu, address: 1, baud: 9600}]\nsimulation:\n",
    ),
)


@pytest.mark.parametrize(("for_s", "code"), [(40.0, RUNAWAY_BELOW), (63.0, 0)])
def test_a_setpoint_raised_while_the_machine_cools_trips_as_check_says(
    for_s: float, code: int
) -> None:
    """`check` refuses up to 62 s: at 58 °C the rule is active, and the heater's heat comes late."""
    controller = controller_of(COOLING)
    loop = controller.loops["air"]
    runaway = loop.protection.runaway.model_copy(update={"for_s": for_s})
    protection = loop.protection.model_copy(update={"runaway": runaway})
    loops = {"air": loop.model_copy(update={"protection": protection})}
    controller = controller.model_copy(update={"loops": ReadOnlyDict(loops)})

    def told(*again: Mapping[str, Any]) -> StepLog:
        hot = {"at": "1 s", "write": {"air.enabled": True, "air.setpoint": "70 °C"}}
        low = {"at": "10 min", "write": {"air.setpoint": "10 °C"}}
        lines = events(hot, low, *again, {"for": "30 min"})
        return bench(controller, ReferenceDevice(controller), lines).steps["air"]

    log = told()
    at_s = log["time_s"][(log["time_s"] > 600) & (log["temperature_c"] < 58.2)][0]
    log = told({"at": f"{at_s} s", "write": {"air.setpoint": "70 °C"}})
    assert set(log["fault.code"].tolist()) == {0, code}
