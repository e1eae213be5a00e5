"""To the last bit, and what no course of `chamber.txt` can tell; every sensor has its reference."""

from importlib import import_module

import numpy as np
import pytest
from reference_machines import STEP_A, Kiln, Player, kiln_of, nozzle_of
from rig.specs import EXAMPLES, example

from heatwright.sim.reference import Reference
from heatwright.sim.reference.inputs import Orders
from heatwright.sim.reference.numbers import Single, filter_share, steps
from heatwright.spec import BOARDS, Pid, Sensor, ThreePosition, kinds

FREE = {"heating": None, "runaway": None, "frozen": None, "rising_while_off": None}


def test_every_operation_is_rounded_to_single_precision(vary):
    gains = {"kind": "pid", "kp": 0.1, "ki": 0.3, "kd": 0.7, "derivative_filter": "3 s"}
    player = Player(vary(**FREE, algorithm=Pid.model_validate(gains)))
    player.feed(40.0)
    record = player.feed(40.0625)
    kp, ki, kd = np.float32([0.1, 0.3, 0.7])
    integral = np.float32(0.0) + ki * np.float32(10.0)
    integral = integral + ki * np.float32(9.9375)
    derivative = np.float32(0.25) * np.float32(-0.0625)
    expected = kp * np.float32(9.9375) + integral + kd * derivative
    assert record["duty_percent"].tobytes() == expected.tobytes()
    assert isinstance(record["duty_percent"], np.float32)
    assert float(record["duty_percent"]) != 0.1 * 9.9375 + 0.3 * 19.9375 - 0.7 * 0.015625


def test_durations_in_whole_milliseconds_and_the_shares_of_filters():
    assert 0.3 / 0.1 < 3
    found = [steps(0.3, 0.1), steps(0.29, 0.1), steps(0.01, 1.0), steps(120.0, 1.0)]
    assert found == [3, 2, 1, 120]
    assert filter_share(1.0, 4.0) == Single(0.2)
    assert filter_share(1.0, 0.0) == 1


def test_the_sum_is_in_the_order_of_the_slots_and_single():
    """The fourth reading takes the place of the first: (4th + 2nd) + 3rd, times a single 1/3."""
    readings = [np.float32(x) for x in (1000.5078125, 0.0234375, 777.125, 33.3359375)]
    kiln = Kiln(kiln_of(average="moving_average: 3"))
    record = kiln.feed_all([float(x) for x in readings])[-1]
    expected = (readings[3] + readings[1] + readings[2]) * np.float32(1 / 3)
    assert record["temperature_c"] == expected


@pytest.mark.parametrize("temperature_c", [0.0, 47.5, 48.0, 50.0, 52.0, 52.5, 69.0])
def test_never_both(vary, temperature_c):
    wide = {"kind": "three_position", "dead_band": "2 K", "hysteresis": "2 K", "lead": "5 s"}
    player = Player(vary(**FREE, algorithm=ThreePosition.model_validate(wide)))
    for reading_c in (40.0, temperature_c, temperature_c, 60.0, temperature_c):
        record = player.feed(reading_c)
        assert not (record["algorithm.heating"] and record["algorithm.cooling"])


def test_an_acknowledgement_without_a_fault_changes_nothing(vary):
    one, other = Player(vary()), Player(vary())
    for temperature_c in (20.0, 20.5, 21.0):
        assert one.feed(temperature_c) == other.feed(temperature_c, acknowledge=True)


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
    ("offset_v", "raw", "amperes"),
    [(0.0, 400, Single(STEP_A / 4) * Single(400) + Single(STEP_A / 2)),
     (2.5, 0, 0.0), (2.5, 4 * 512, pytest.approx(STEP_A / 2))],
)  # fmt: skip
def test_amperes_are_the_middle_of_the_step_and_never_negative(offset_v, raw, amperes):
    controller = nozzle_of()
    sensor = controller.sensors["current"].model_copy(update={"offset_v": offset_v})
    moved = controller.model_copy(update={"sensors": {**controller.sensors, "current": sensor}})
    orders = Orders(current_raw=raw)
    record = Reference(moved, "nozzle").step(0, 320, Single(50), orders=orders)
    assert record["current.amperes"] == amperes


@pytest.mark.parametrize(
    ("resolution", "code"), [("9 bit", 808), ("10 bit", 804), ("11 bit", 806), ("12 bit", 805)]
)
def test_ds18b20_rounds_to_its_resolution_and_ends_at_its_range(resolution, code):
    module = import_module("heatwright.sim.reference.ds18b20")
    told = {"kind": "ds18b20", "pin": "A1", "resolution": resolution}
    sensor = module.IdealSensor(module.Ds18b20.model_validate(told), BOARDS["mega2560"])
    assert sensor.read(50.32) == (0, code)
    assert (sensor.read(-60.0), sensor.read(200.0)) == ((0, -880), (0, 2000))
