"""The examples with a converter, binary and model each in closed loop."""

import pytest
from rig.avr import whole
from rig.specs import example

from heatwright.cli.chips import complaints
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.metrics import metrics
from heatwright.sim.replay import replay
from heatwright.sim.trace import Trace
from heatwright.spec import Spec

NAMES = ("press", "hotplate")


@pytest.mark.parametrize("name", NAMES)
def test_the_binary_meets_what_is_expected(name: str) -> None:
    spec = example(name)
    device = AvrDevice(spec.controller, whole(name))
    trace = bench(spec.controller, device)
    assert complaints(device) == ()
    (loop,) = spec.controller.loops
    result = replay(spec.controller, trace.steps[loop])
    assert (result.mismatches, set(result.unchecked)) == (0, {"fault.time_s"})
    expected(spec, trace)


@pytest.mark.parametrize("name", NAMES)
def test_the_model_does(name: str) -> None:
    spec = example(name)
    expected(spec, bench(spec.controller, ReferenceDevice(spec.controller)))


def expected(spec: Spec, trace: Trace) -> None:
    found = metrics(trace, spec.controller)
    wanted = spec.controller.simulation.expect
    assert 0 <= found.overshoot_k <= wanted.overshoot_k
    assert found.steady_error_k <= wanted.steady_k
    assert set(trace.steps[next(iter(spec.controller.loops))]["fault.code"]) == {0}
