from collections.abc import Callable

import pytest
from analog_specs import BED, CIRCUITS, KEYS, PLOTTER, bed, built

from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf
from heatwright.spec import Spec, load_text

PowerOn = Callable[[], AvrDevice]

TWO = """
  far: {kind: thermistor, pin: A13, divider: {pull_up: 4.7 kΩ},
        curve: {resistance: 100 kΩ, at: 25 °C, beta: 3950 K}, range: 0 °C .. 150 °C, oversample: 3}
"""


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Spec], Elf]:
    """The binary of a spec."""
    return lambda spec: Elf(built(spec, tmp_path_factory.mktemp("bed")))


@pytest.fixture(scope="session")
def bed_program(made: Callable[[Spec], Elf]) -> Elf:
    return made(bed("hotend"))


@pytest.fixture
def plate(bed_program: Elf) -> AvrDevice:
    """The bed on a thermistor, at 50 °C, just powered on."""
    return powered(bed("hotend"), bed_program)


@pytest.fixture(scope="session")
def keyed_program(made: Callable[[Spec], Elf]) -> Elf:
    return made(bed("hotend", interface=KEYS))


@pytest.fixture
def keyed(keyed_program: Elf) -> AvrDevice:
    """The same with the display's keys, which are on another channel."""
    return powered(bed("hotend", interface=KEYS), keyed_program)


@pytest.fixture
def two(made: Callable[[Spec], Elf]) -> AvrDevice:
    """A Mega with sensors on ADC1 and, through MUX5, on ADC13."""
    spec = load_text(two_sensors(), "two.yaml")
    return AvrDevice(spec.controller, made(spec))


def powered(spec: Spec, program: Elf) -> AvrDevice:
    device = AvrDevice(spec.controller, program)
    device.sense("bed", 50.0)
    return device


def two_sensors() -> str:
    """The bed's text with a second sensor, heater and loop."""
    text = BED.replace("BOARD", "mega2560").replace("SENSOR", CIRCUITS["hotend"])
    text = text.replace("INTERFACE", PLOTTER).replace("\noutputs:", f"{TWO}\noutputs:")
    heater = "  other: {kind: pwm, pin: D5, frequency: 490 Hz, power: 120 W}\n"
    text = text.replace("\nloops:", f"\n{heater}\nloops:")
    start, end = text.index("  bed:\n    sensor: bed"), text.index("safety:")
    loop = text[start:end].replace("bed", "far").replace("heater: heater", "heater: other")
    text = text[:end] + loop + text[end:]
    text = text.replace("heat: {heater: plate}", "heat: {heater: plate, other: plate}")
    return text.replace("{bed: {node", "{far: {node: plate, lag: 4 s}, bed: {node")
