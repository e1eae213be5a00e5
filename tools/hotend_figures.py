"""Print the hotend's published figures beside ours: gains and limits in counts of 255, and M303.

What its firmware's users look up by hand, the limits of the integral, is here what M303 proposes
after it has tuned at the lowest and at the highest temperature of a print, from cold, with the
reference model, which the firmware equals bit for bit. A proposal is within the limits of the spec,
whose least integral is above what is proposed for the lowest temperature: that row is there twice,
of the spec as it is and with `integral.minimum` at 0.

    python tools/hotend_figures.py spec/examples/extruder.yaml
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np

from heatwright.cli.tables import show, table
from heatwright.sim.bench import ReferenceDevice, bench
from heatwright.sim.reference.outputs.output import rated_share
from heatwright.sim.tuning.trial import ending, tune
from heatwright.spec import Controller, Pid, PwmOutput, Thermistor, load

HEATER, LOOP, SENSOR = "heater", "nozzle", "nozzle"
COUNTS = 255
"""Full duty of the published firmware."""
CODES = 1023
"""Full scale of its ADC, and of ours."""
RATED_V, SUPPLY_V = 12.0, 18.0
CYCLES = 5
COLDEST_C, PLA_C, ABS_C = 170.0, 180.0, 240.0

Figure = tuple[str, str, float, int]
"""What it is, as published, ours, digits."""


@click.command()
@click.argument("path", metavar="SPEC", type=click.Path(path_type=Path, exists=True))
def main(path: Path) -> None:
    """Print the figures of a spec's hotend."""
    rows = []
    for what, published, ours, digits in figures(load(path).controller):
        residual = round(ours - float(published.rsplit(maxsplit=1)[-1]), digits) + 0.0
        rows.append((what, published, f"{ours:.{digits}f}", f"{residual:+.{digits}f}"))
    show(table(("figure", "published", "ours", "residual"), rows))


def figures(controller: Controller) -> Iterator[Figure]:
    """Yield the figures of a controller, and of its machine."""
    spec, heater, sensor = (
        controller.loops[LOOP],
        controller.outputs[HEATER],
        controller.sensors[SENSOR],
    )
    law = spec.algorithm
    assert isinstance(law, Pid)  # noqa: S101 - else it has no such figures
    assert law.band_k is not None  # noqa: S101 - the same
    assert isinstance(heater, PwmOutput)  # noqa: S101 - the same
    assert isinstance(sensor, Thermistor)  # noqa: S101 - the same
    yield "four readings of the ADC are at most", "4092", sensor.oversample * CODES, 0
    yield "PID within ±, K", "10", law.band_k, 0
    yield "P, counts/K", "24", counts(law.kp), 2
    yield "I, counts/(K·s)", "0.88", counts(law.ki), 2
    yield "D, counts·s/K", "80", counts(law.kd), 1
    yield "integral at least, counts", "60", counts(law.integral.minimum_percent), 0
    yield "integral at most, counts", "150", counts(law.integral.maximum_percent), 0
    overfed = heater.model_copy(update={"supply_v": SUPPLY_V, "rated_v": RATED_V})
    yield "a heater of 12 V from 18 V, counts", "113", COUNTS * rated_share(overfed), 0
    free = law.integral.model_copy(update={"minimum_percent": 0.0})
    opened = controller.with_loop(
        LOOP, spec.model_copy(update={"algorithm": law.model_copy(update={"integral": free})})
    )
    yield "least integral below what 170 °C takes, counts", "about 30", below(controller), 0
    yield "the same with integral.minimum at 0, counts", "about 30", below(opened), 0
    yield "most integral at 180 °C, counts", "about 130", most(controller, PLA_C), 0
    yield "most integral at 240 °C, counts", "about 180", most(controller, ABS_C), 0


def counts(percent: float) -> float:
    """Return a share of full duty, or a gain, in the published firmware's counts."""
    return percent * COUNTS / 100


def below(controller: Controller) -> float:
    """Return by how much the proposed minimum is below what the coldest print takes, in counts."""
    last = tuned(controller, COLDEST_C)
    return counts(float(last["autotune.hold_percent"] - last["autotune.integral_minimum"]))


def most(controller: Controller, celsius: float) -> float:
    """Return the maximum of the integral that is proposed at a temperature, in counts."""
    return counts(float(tuned(controller, celsius)["autotune.integral_maximum"]))


def tuned(controller: Controller, celsius: float) -> np.void:
    """Tune from cold, and return the last control step."""
    spec = controller.loops[LOOP]
    assert spec.autotune is not None  # noqa: S101 - else M303 would be refused
    events = (*tune(controller, LOOP, celsius, CYCLES), ending(spec.autotune.timeout_s))
    last: np.void = bench(controller, ReferenceDevice(controller), events).steps[LOOP][-1]
    assert last["autotune.result"] == 2  # noqa: S101 - done
    return last


if __name__ == "__main__":
    main()
