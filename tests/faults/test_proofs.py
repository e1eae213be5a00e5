"""A fan that has to prove that it turns, beside other outputs, loops and interfaces."""

from functools import cache

import pytest
from rig.avr import whole
from rig.specs import changed, controller_of

from heatwright.sim.faults import catalogue, starts, try_fault
from heatwright.sim.faults.fault import Fault
from heatwright.sim.faults.world import Site
from heatwright.sim.native.relay import Wire

CHAMBER = changed(
    "chamber",
    ("fan: {kind: digital, pin: D11, runs: always}",
     "fan: {kind: digital, pin: D11, active: low, runs: always, proof: {pin: A3, within: 2 s}}"),
)  # fmt: skip
SHARED = changed(
    "printer",
    ("outputs:\n", "outputs:\n  air: {kind: digital, pin: D11, runs: always, "
     "proof: {pin: D6, within: 3 s}}\n"),
    ("    heater: hotend_heater\n", "    heater: hotend_heater\n    fan: air\n"),
    ("    heater: bed_heater\n", "    heater: bed_heater\n    fan: air\n"),
)  # fmt: skip
"""Two loops with one fan: the first one's step judges it, both are without heat."""
MACHINES = {
    "dryer": ("dryer", "fan", ""),
    "chamber": (CHAMBER, "fan", ""),
    "printer": (SHARED, "air", "hotend."),
}


@cache
def faults_of(machine: str) -> dict[str, Fault]:
    text, _, _ = MACHINES[machine]
    controller = controller_of(text)
    site = Site(controller, next(iter(controller.loops)), whole(text))
    return {fault.id: fault for fault in catalogue(controller, site.program)}


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("what", ["stuck", "proof_torn"])
def test_no_heat_without_proof(machine: str, what: str) -> None:
    _, fan, prefix = MACHINES[machine]
    result = try_fault(faults_of(machine)[f"{prefix}{fan}_{what}"])
    assert (result.detail, result.rule) == ("", "fan_stopped")


def test_air_that_comes_back_in_time_is_no_fault() -> None:
    """The heater is off meanwhile, and on again."""
    world = faults_of("dryer")["fan_stuck"].make()
    proof = world.device.proofs["fan"]
    for _ in range(3):
        proof.fail(wire=Wire.TORN)
        world.run(0.1)
        torn_s = world.now_s
        world.run(2.0)
        assert (world.heater.last_on_s(torn_s), world.fault) == (None, 0)
        proof.fail()
        world.run(0.1)
        assert world.until(starts.heater_is_on, 10.0)


def test_both_loops_of_a_fan_are_without_heat() -> None:
    fault = faults_of("printer")["hotend.air_stuck"]
    world = fault.make()
    world.send("M140 S60")
    assert world.until(lambda now: now.device.outputs["bed_heater"].on, 10.0)
    fault.cause(world)
    world.run(0.1)
    stuck_s = world.now_s
    world.run(2.0)
    assert (world.heaters.last_on_s(stuck_s), world.fault) == (None, 0)
