"""A fan that has to prove that it turns, beside other outputs, loops and interfaces."""

from collections.abc import Iterator

import pytest
from fault_machines import faults_of, judged
from rig.specs import changed

from heatwright.sim.faults import starts
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
COUNTED = changed(
    SHARED, ("proof: {pin: D6, within: 3 s}", "active: low, proof: {pin: D6, within: 3 s, "
             "tachometer: {speed: 5800 rpm, pulses: 3, minimum: 900 rpm, maximum: 7000 rpm}}"),
)  # fmt: skip
"""As fast, and with limits as far apart, as can be counted."""
MACHINES = {
    "dryer": ("dryer", "fan"),
    "incubator": ("incubator", "fan"),
    "counted": (COUNTED, "hotend.air"),
    "chamber": (CHAMBER, "fan"),
    "printer": (SHARED, "hotend.air"),
}

COUNTED_ALONE = ("weak", "proof_shorted", "proof_noisy")


def unproven() -> Iterator[tuple[str, str]]:
    for machine in MACHINES:
        counted = COUNTED_ALONE if machine in {"incubator", "counted"} else ()
        for what in ("stuck", "proof_torn", *counted):
            yield machine, what


@pytest.mark.parametrize(("machine", "what"), list(unproven()))
def test_no_heat_without_proof(machine: str, what: str) -> None:
    spec, fan = MACHINES[machine]
    assert judged(spec, f"{fan}_{what}") == "fan_stopped"


@pytest.mark.parametrize("machine", ["incubator", "counted"])
@pytest.mark.parametrize("what", ["turns_slow", "turns_fast"])
def test_a_fan_at_its_limits_is_proof(machine: str, what: str) -> None:
    spec, fan = MACHINES[machine]
    assert judged(spec, f"{fan}_{what}") is None


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
        assert world.until(starts.heater_on(world.site), 10.0)


def test_both_loops_of_a_fan_are_without_heat() -> None:
    fault = faults_of(SHARED)["hotend.air_stuck"]
    world = fault.make()
    world.send("M140 S60")
    assert world.until(lambda now: now.device.outputs["bed_heater"].on, 10.0)
    fault.cause(world)
    world.run(0.1)
    stuck_s = world.now_s
    world.run(2.0)
    assert (world.heaters.last_on_s(stuck_s), world.fault) == (None, 0)
