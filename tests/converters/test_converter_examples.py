"""The examples with a converter, binary and model each in closed loop."""

import pytest
from rig.avr import whole
from rig.specs import example

from heatwright.cli.chips import complaints
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.metrics import metrics
from heatwright.sim.replay import replay


@pytest.mark.parametrize("name", ["press", "hotplate"])
def test_the_binary_meets_what_is_expected(name: str) -> None:
    controller = example(name).controller
    device, (loop,) = AvrDevice(controller, whole(name)), controller.loops
    wanted = controller.simulation.expect
    for each in (ReferenceDevice(controller), device):
        trace = bench(controller, each)
        found = metrics(trace, controller)
        assert 0 <= found.overshoot_k <= wanted.overshoot_k
        assert found.steady_error_k <= wanted.steady_k
        assert set(trace.steps[loop]["fault.code"]) == {0}
    assert complaints(device) == ()
    result = replay(controller, trace.steps[loop])
    assert (result.mismatches, set(result.unchecked)) == (0, {"fault.time_s"})
