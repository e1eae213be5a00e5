import csv

import numpy as np
import pytest
from machines import events, modelled, noisy

from heatwright.sim.bench import PROGRESS_REPORTS, ReferenceDevice, bench
from heatwright.sim.trace import TraceEvent
from heatwright.spec import Pid, PwmOutput, TimeProportionalOutput

HEATER = {"pin": "D3", "power": "240 W"}
PWM = PwmOutput.model_validate({"kind": "pwm", "frequency": "490 Hz", **HEATER})
WINDOWS = TimeProportionalOutput.model_validate(
    {"kind": "time_proportional", "window": "1 s", **HEATER}
)


@pytest.fixture(scope="module")
def run():
    return modelled("chamber").trace


def test_one_step_per_period_up_to_the_end(run):
    log = run.steps["air"]
    assert log["time_s"].tolist() == [float(n) for n in range(1, 1801)]
    assert log["steps"].tolist() == list(range(1, 1801))
    assert run.events == tuple(TraceEvent(pytest.approx(t), "up") for t in (10.0, 10.2, 10.4))
    assert log["setpoint_c"][8:11].tolist() == [20.0, 30.0, 50.0]  # a press at 10 s comes first


def test_the_setpoint_stays_in_its_range(chamber):
    keys = ({"at": f"{at_s} s", "press": key, "times": 9} for at_s, key in ((1, "up"), (5, "down")))
    setpoints_c = modelled(chamber, *keys, {"for": "10 s"}).log["setpoint_c"]
    assert (setpoints_c.max(), setpoints_c[-1]) == (70, 10)


def test_a_held_key_is_one_press(chamber):
    device = ReferenceDevice(chamber)
    for time_s in (1.0, 2.0, 3.0):
        device.press("up")
        device.advance(time_s)
    device.press(None)
    device.press("up")
    device.advance(5.0)
    # The step at 3 s is done after it.
    assert device.steps("air")["setpoint_c"].tolist() == [30, 30, 40, 40]


def test_select_acknowledges(chamber):
    device = ReferenceDevice(chamber)
    device.sense("air", 90.0)
    device.advance(2.5)
    device.sense("air", 30.0)
    device.advance(4.5)
    device.press("select")
    device.advance(6.5)
    assert device.steps("air")["fault.code"].tolist() == [6, 6, 6, 6, 0, 0]


def test_readings_are_what_the_sensor_felt_when_its_conversion_began(run):
    log = run.steps["air"]
    felt_c = np.interp(log["time_s"] - 0.8, run.times_s, run.sensed_c["air"])  # row before 0.78 s
    assert log["reading_raw"].tolist() == np.floor(felt_c * 16 + 0.5).tolist()


def test_the_heater_follows_the_step(run):
    log = run.steps["air"]
    after = np.searchsorted(run.times_s, log["time_s"] + 0.05)
    on = run.on_fraction["heater"]
    assert np.array_equal(on[after[:-1]] * 100, log["duty_percent"][:-1])
    assert (run.on_fraction["fan"][1:] == 1).all()


def test_seed_changes_the_noise(chamber):
    one, same, other = (
        modelled(noisy(chamber, 0.1), {"for": "20 s"}, seed=seed).trace.sensed_c["air"].tolist()
        for seed in (1, 1, 2)
    )
    assert one == same != other


def test_progress_ends_at_the_end(chamber):
    told = []
    lines, tell = events({"for": "60 s"}), lambda now_s, end_s: told.append(now_s / end_s)
    bench(chamber, ReferenceDevice(chamber), lines, progress=tell)
    assert told == sorted(told)
    assert 0.99 < told[-1] <= 1
    assert len(told) <= 2 * PROGRESS_REPORTS


@pytest.mark.parametrize(("output", "resolution"), [(PWM, 1 / 256), (WINDOWS, 10e-3)])
def test_the_heat_is_what_was_asked_for(vary, output, resolution):
    controller = vary(algorithm=Pid(kind="pid", kp=1), output=output)
    keys = {"at": "1.5 s", "press": "up", "times": 3}
    trace = modelled(controller, keys, {"for": "30 s"}).trace
    log = trace.steps["air"][:-1]  # what the last step asks for is still to come
    assert 25 < log["duty_percent"].max() < 100
    until = np.searchsorted(trace.times_s, 30.0 + 1e-9)
    given_s = (trace.on_fraction["heater"] * np.diff(trace.times_s, prepend=0.0))[:until].sum()
    asked_s = log["duty_percent"].astype(float).sum() / 100
    assert given_s == pytest.approx(asked_s, abs=len(log) * resolution / 2)


def test_a_bench_needs_a_machine(chamber):
    bare = chamber.model_copy(update={"simulation": None})
    with pytest.raises(ValueError, match="no `simulation`"):
        bench(bare, ReferenceDevice(bare))


def test_csv_has_units_and_the_state_of_the_last_step(chamber, tmp_path):
    trace = bench(chamber, ReferenceDevice(chamber), events({"for": "3 s"}), step_s=0.1)
    path = tmp_path / "run.csv"
    trace.write_csv(path)
    with path.open(encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert header[:5] == ["time [s]", "element [°C]", "air [°C]", "walls [°C]", "air sensed [°C]"]
    units = {"temperature_c": "°C", "algorithm.rate_k_per_s": "K/s", "duty_percent": "%"}
    assert {f"air.{name} [{unit}]" for name, unit in units.items()} <= {*header}
    steps = [row[header.index("air.steps")] for row in rows]
    assert steps == [""] * 10 + ["1"] * 10 + ["2"] * 10 + ["3"] * 2
