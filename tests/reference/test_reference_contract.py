"""Every sensor, algorithm and output of the language has its reference."""

from importlib import import_module

import pytest

from heatwright.sim.reference import Reference
from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.numbers import Single
from heatwright.spec import Algorithm, Output, Sensor, kinds

HEATERS = {
    "digital": {},
    "pwm": {"frequency": "490 Hz"},
    "time_proportional": {"window": "1 s"},
}
ALGORITHMS = {"on_off": {}, "pid": {"kp": 50}}


@pytest.mark.parametrize("kind", kinds(Sensor))
def test_every_sensor_can_be_read(chamber, kind):
    module = import_module(f"heatwright.sim.reference.{kind}")
    sensor = module.IdealSensor(chamber.sensors["air"])
    assert module.temperature(sensor.code(50.0)) == 50.0


@pytest.mark.parametrize("output", kinds(Output))
@pytest.mark.parametrize("algorithm", kinds(Algorithm))
def test_every_algorithm_drives_every_output(vary, algorithm, output):
    controller = vary(
        algorithm=kinds(Algorithm)[algorithm].model_validate(
            {"kind": algorithm, **ALGORITHMS[algorithm]}
        ),
        output=kinds(Output)[output].model_validate(
            {"kind": output, "pin": "D3", "power": "240 W", **HEATERS[output]}
        ),
    )
    reference = Reference(controller, "air")
    course = course_of(controller, "heater")
    for raw, expected_us in ((20 * 16, 1e6), (55 * 16, 0.0)):
        reference.step(0, raw, Single(50.0))
        course.apply(reference.output.counts)
        assert course.advance(1_000_000 if expected_us else 2_000_000) == expected_us
        reference = Reference(controller, "air")


@pytest.mark.parametrize(
    ("resolution", "code"), [("9 bit", 808), ("10 bit", 804), ("11 bit", 806), ("12 bit", 805)]
)
def test_ds18b20_rounds_to_its_resolution(resolution, code):
    module = import_module("heatwright.sim.reference.ds18b20")
    sensor = module.Ds18b20.model_validate(
        {"kind": "ds18b20", "pin": "A1", "resolution": resolution}
    )
    assert module.IdealSensor(sensor).code(50.32) == code


def test_ds18b20_ends_at_its_range(chamber):
    module = import_module("heatwright.sim.reference.ds18b20")
    sensor = module.IdealSensor(chamber.sensors["air"])
    assert (sensor.code(-60.0), sensor.code(200.0)) == (-880, 2000)
