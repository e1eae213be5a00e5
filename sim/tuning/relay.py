"""The firmware's autotune, run by the reference model on the spec's machine."""

from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.plots.plot_data import fault_label, faults
from heatwright.sim.tuning.gains import Gains
from heatwright.sim.tuning.orders import tune
from heatwright.sim.tuning.trial import Progress, ending
from heatwright.spec import Controller

DONE = 2
RESULTS = {
    1: "it did not come to an end",
    3: "it took longer than its time-out",
    4: "it was stopped",
    5: "the machine became too hot",
    6: "its results are not usable",
}
"""Why there are no gains, by autotune.result (docs/control.md, "Autotune")."""

AFTERWARDS_S = 10.0
"""Time after the time-out within which the result must be there."""


class TuningFailed(Exception):
    """The experiment found no gains; the text says why."""


def relay(
    controller: Controller, loop: str, target_c: float, progress: Progress | None = None
) -> Gains:
    """Run the relay experiment from cold, as the firmware does, and return its gains.

    Raises TuningFailed: a protection tripped, or the experiment found nothing.
    """
    spec = controller.loops[loop]
    pid = spec.algorithm.pid
    assert pid is not None  # noqa: S101 - the checks ensure it
    assert spec.autotune is not None  # noqa: S101 - the caller has looked
    length_s = spec.autotune.timeout_s + AFTERWARDS_S
    scenario = (*tune(controller, loop, target_c, spec.autotune.cycles), ending(length_s))
    trace = bench(controller, ReferenceDevice(controller), scenario, progress=progress)
    log = trace.steps[loop]
    for _, code in faults(log):
        raise TuningFailed(f"{fault_label(code)} tripped")
    last = log[-1]
    result = int(last["autotune.result"])
    if result != DONE:
        raise TuningFailed(RESULTS.get(result, "it did not start"))
    kp, ki, kd = (float(last[f"autotune.{name}"]) for name in ("kp", "ki", "kd"))
    least, most = (float(last[f"autotune.integral_{end}"]) for end in ("minimum", "maximum"))
    return Gains(kp, ki, kd, pid.derivative_filter_s, (least, most))
