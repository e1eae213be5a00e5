"""Print ours of published figures that are no key of a spec: computed from its keys and the code.

The generated C of a spec has what stands here, held by tests of its own.

    python tools/published_figures.py spec/examples/kiln.yaml
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click

from heatwright.cli.tables import show, table
from heatwright.generator import plan_firmware, render
from heatwright.generator.plan.interfaces.nextion import TURN_S
from heatwright.sim.circuits.ports import pin_v
from heatwright.sim.interfaces.lcd_keypad.keypad import CODES as KEYS
from heatwright.spec import Controller, Spec, load
from heatwright.spec.nextion import HEIGHT, WIDTH, chart_top_c
from heatwright.spec.nextion.control import CONTROL_CHART_EVERY_S, CONTROL_CHART_PX
from heatwright.spec.sensing.conversion import CODES
from heatwright.spec.sensing.curves import LinearPlatinum, Platinum
from heatwright.spec.sensing.max31856 import HIGHEST_C

Figure = tuple[str, float | tuple[float, ...], str]
"""What it is, ours, unit."""

CURVE = Platinum(1000.0)
"""An element after IEC 60751."""
OF_THE_STANDARD = 3851.0
"""The coefficient by which the standard names it: its mean from 0 °C to 100 °C, ppm/K."""


@click.command()
@click.argument("path", metavar="SPEC", type=click.Path(path_type=Path, exists=True))
def main(path: Path) -> None:
    """Print the figures of a machine of the examples."""
    spec = load(path)
    machine = spec.controller.identity.name
    if machine not in MACHINES:
        raise click.UsageError(f"of {machine} there are none; of {', '.join(MACHINES)}")
    rows = [(what, told(ours), unit) for what, ours, unit in MACHINES[machine](spec)]
    show(table(("figure", "ours", "unit"), rows))


def told(ours: float | tuple[float, ...]) -> str:
    """Write numbers down, none of them in powers of ten."""
    return ", ".join(f"{each:.7g}" for each in (ours if isinstance(ours, tuple) else (ours,)))


def setpoints(controller: Controller, loop: str) -> Figure:
    """Return what may be asked of a loop."""
    asked = controller.loops[loop].setpoint
    return "setpoints", (asked.minimum_c, asked.maximum_c), "°C"


def of_kiln(spec: Spec) -> Iterator[Figure]:
    """Yield what its converter and its display have."""
    controller = spec.controller
    sensor: Any = controller.sensors["chamber"]
    types = sensor.selectable
    yield "step of a reading", sensor.step_k, "K"
    yield f"highest of types {', '.join(types)}", tuple(HIGHEST_C[each] for each in types), "°C"
    yield "screen", (WIDTH, HEIGHT), "pixels"
    yield "running chart", CONTROL_CHART_PX[0] * CONTROL_CHART_EVERY_S, "s"
    yield f"its {CONTROL_CHART_PX[1]} pixels", chart_top_c(controller), "°C"
    yield "from one instruction to the next at least", TURN_S * 1e3, "ms"


def of_chamber(spec: Spec) -> Iterator[Figure]:
    """Yield its sensor's steps and times, what its keys give, and where the firmware parts them."""
    sensor: Any = spec.controller.sensors["air"]
    resolved = [sensor.model_copy(update={"resolution_bits": bits}) for bits in range(9, 13)]
    yield "steps at 9 to 12 bit", tuple(each.step_k for each in resolved), "K"
    for each in resolved:
        yield f"conversion at {each.resolution_bits} bit", each.conversion_s * 1e3, "ms"
    yield "codes of the keys", tuple(KEYS.values()), ""
    limits = re.findall(r"_BELOW = (\d+) / 4", render(plan_firmware(spec))["src/keypad.c"])
    yield "limits between them", tuple(map(float, limits)), ""
    yield setpoints(spec.controller, "air")


def of_feeder(spec: Spec) -> Iterator[Figure]:
    """Yield what its sensor and the published law's row have."""
    controller = spec.controller
    sensor: Any = controller.sensors["nozzle"]
    yield "element at 250 °C", round(Platinum(100.0).ohm(250), 2), "Ω"
    yield "amplifier at 0 °C, 250 °C", tuple(map(float, pin_v(sensor, [0, 250]).round(2))), "V"
    yield "bits of the ADC", math.log2(CODES), "bit"
    row = controller.comparison[0]
    law: Any = row.algorithm
    step = law.ki * controller.loops["nozzle"].period_s
    ends = (law.integral.minimum_percent / step, law.integral.maximum_percent / step)
    yield "limits of the sum of errors", tuple(round(each) for each in ends), "K"
    yield setpoints(controller, "nozzle")


def of_extruder(spec: Spec) -> Iterator[Figure]:
    """Yield what may be asked of it."""
    yield setpoints(spec.controller, "nozzle")


def of_fabricator(spec: Spec) -> Iterator[Figure]:
    """Yield how far its line is from the curve of an element of IEC 60751."""
    sensor: Any = spec.controller.sensors["nozzle"]
    for ppm_per_k in (sensor.alpha_ppm_per_k, OF_THE_STANDARD):
        line = LinearPlatinum(CURVE.zero_ohm, ppm_per_k * 1e-6)
        for at_c in (200, 300):
            off_k = line.celsius(CURVE.ohm(at_c)) - at_c
            yield f"a line of {ppm_per_k:.0f} ppm/K is off at {at_c} °C by", round(off_k, 1), "K"


MACHINES: dict[str, Callable[[Spec], Iterator[Figure]]] = {
    "kiln": of_kiln,
    "chamber": of_chamber,
    "feeder": of_feeder,
    "fabricator": of_fabricator,
    "extruder": of_extruder,
}

if __name__ == "__main__":
    main()
