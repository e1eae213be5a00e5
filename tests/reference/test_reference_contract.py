"""Every sensor, algorithm and output of the language has its reference."""

from importlib import import_module

import pytest

from heatwright.sim.reference import Reference
from heatwright.sim.reference.course import course_of
from heatwright.sim.reference.numbers import Single
from heatwright.spec import BOARDS, Algorithm, Sensor, Switch, kinds

MEGA = BOARDS["mega2560"]
SPI = {"chip_select": "D49", "clock": "D52", "data_out": "D50"}
SENSORS = {
    "analog": {"pin": "A13", "scale": "10 mV/K", "range": "2 °C .. 150 °C"},
    "current": {"pin": "A13", "scale": "50 mV/A", "offset": "0.5 V"},
    "ds18b20": {"pin": "A1"},
    "max31855": SPI,
    "max31856": {**SPI, "data_in": "D51"},
    "max6675": SPI,
    "rtd": {"pin": "A13", "element": "pt1000", "divider": {"pull_up": "1 kΩ"},
            "range": "0 °C .. 300 °C"},
    "thermistor": {"pin": "A13", "divider": {"pull_up": "4.7 kΩ"}, "range": "0 °C .. 300 °C",
                   "curve": {"resistance": "100 kΩ", "at": "25 °C", "beta": "4267 K"}},
}  # fmt: skip
HEATERS = {"digital": {}, "pwm": {"frequency": "490 Hz"}, "time_proportional": {"window": "1 s"}}
ALGORITHMS = {"on_off": {}, "pid": {"kp": 50}, "three_position": {"dead_band": "2 K"}}
AMPERES_A_STEP = 5.0 / 1024 / 0.050


@pytest.mark.parametrize("kind", kinds(Sensor))
def test_every_sensor_can_be_read(kind):
    module = import_module(f"heatwright.sim.reference.{kind}")
    sensor = kinds(Sensor)[kind].model_validate({"kind": kind, **SENSORS[kind]})
    status, raw = module.IdealSensor(sensor, MEGA).read(50.0)
    assert status == 0
    step = AMPERES_A_STEP if kind == "current" else sensor.step_k
    assert abs(module.converter(sensor, MEGA)(raw) - 50.0) <= step


@pytest.mark.parametrize("output", kinds(Switch))
@pytest.mark.parametrize("algorithm", kinds(Algorithm))
def test_every_algorithm_drives_every_output(vary, algorithm, output):
    law = {"kind": algorithm, **ALGORITHMS[algorithm]}
    heater = {"kind": output, "pin": "D3", "power": "240 W", **HEATERS[output]}
    controller = vary(
        algorithm=kinds(Algorithm)[algorithm].model_validate(law),
        output=kinds(Switch)[output].model_validate(heater),
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
def test_ds18b20_rounds_to_its_resolution_and_ends_at_its_range(resolution, code):
    module = import_module("heatwright.sim.reference.ds18b20")
    told = {"kind": "ds18b20", "pin": "A1", "resolution": resolution}
    sensor = module.IdealSensor(module.Ds18b20.model_validate(told), MEGA)
    assert sensor.read(50.32) == (0, code)
    assert (sensor.read(-60.0), sensor.read(200.0)) == ((0, -880), (0, 2000))
