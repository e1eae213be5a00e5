"""Every sensor of the language has its reference; algorithms and outputs: the drawn controllers."""

from importlib import import_module

import pytest
from rig.specs import EXAMPLES, example

from heatwright.spec import BOARDS, Sensor, kinds

SENSORS = {
    sensor.kind: (sensor, controller.board)
    for controller in (example(path.stem).controller for path in sorted(EXAMPLES.glob("*.yaml")))
    for sensor in controller.sensors.values()
}


@pytest.mark.parametrize("kind", kinds(Sensor))
def test_every_sensor_can_be_read(kind):
    """What it tells is within a step of what it feels; a sum has as many codes in a step."""
    module = import_module(f"heatwright.sim.reference.{kind}")
    felt = 1.0 if kind == "current" else 50.0
    status, raw = module.IdealSensor(*SENSORS[kind]).read(felt)
    assert status == 0
    codes = getattr(SENSORS[kind][0], "oversample", 1)
    below, found, above = map(module.converter(*SENSORS[kind]), (raw - codes, raw, raw + codes))
    assert abs(found - felt) <= abs(above - below) / 2


@pytest.mark.parametrize(
    ("resolution", "code"), [("9 bit", 808), ("10 bit", 804), ("11 bit", 806), ("12 bit", 805)]
)
def test_ds18b20_rounds_to_its_resolution_and_ends_at_its_range(resolution, code):
    module = import_module("heatwright.sim.reference.ds18b20")
    told = {"kind": "ds18b20", "pin": "A1", "resolution": resolution}
    sensor = module.IdealSensor(module.Ds18b20.model_validate(told), BOARDS["mega2560"])
    assert sensor.read(50.32) == (0, code)
    assert (sensor.read(-60.0), sensor.read(200.0)) == ((0, -880), (0, 2000))
