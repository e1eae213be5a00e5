"""Known machines are found again from their logs, within what the fit says of itself."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.stats import binom
from suite import amount

from heatwright.sim.identify import Identified, Record, Structure, Unusable, fit
from heatwright.sim.identify.answer import APART, LEAST_LAG_S, WORST_CONDITION, Answer, modes
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import ThermalNetwork

Series = NDArray[np.float64]
POWER_W = 40.0


def machine(  # noqa: PLR0917
    capacity: float = 16.7, resistance: float = 14.7, lag: float = 4.5, delay: float = 1.3,
    noise: float = 0.0, case: tuple[float, float] | None = None,
) -> ThermalNetwork:  # fmt: skip
    """A body, with a case of this capacity and resistance to the body if asked for."""
    nodes, ways = {"body": f"{capacity} J/K"}, [("body", "ambient", resistance)]
    if case is not None:
        nodes["shell"] = f"{case[0]} J/K"
        ways = [("body", "shell", case[1]), ("shell", "ambient", resistance)]
    links = [{"between": [one, other], "resistance": f"{way} K/W"} for one, other, way in ways]
    sense = {"node": "body", "lag": f"{lag} s", "delay": f"{delay} s", "noise": f"{noise} K"}
    parts = {"nodes": nodes, "links": links, "heat": {"heater": "body"}, "sense": {"sensor": sense}}
    return ThermalNetwork.model_validate({"kind": "thermal_network", **parts})


def recorded(
    network: ThermalNetwork, duty: Sequence[float] | Series, *, step_k: float = 0.0, seed: int = 0
) -> Record:
    """What a controller logs that reads this machine, duty for duty."""
    plant = Plant(network, {"heater": POWER_W}, ambient_c=20.0, step_s=1.0, seed=seed)
    readings = []
    for share in duty:
        readings.append(plant.sensed_c()["sensor"])
        plant.step({"heater": share})
    read_c = np.array(readings)
    if step_k:
        read_c = np.round(read_c / step_k) * step_k
    powers_w = np.asarray(duty, dtype=float) * POWER_W
    return Record(np.arange(float(len(read_c))), read_c, powers_w)


def steps(count: int = 1000, *changes: tuple[int, float]) -> Series:
    """A duty of 0 that changes to these at these rows."""
    duty = np.zeros(count)
    for row, share in changes or ((20, 0.5), (600, 0.2)):
        duty[row:] = share
    return duty


def as_csv(record: Record) -> str:
    rows = zip(record.times_s, record.readings_c, record.powers_w, strict=True)
    lines = [f"{t:g},{read_c:.3f},{100 * power_w / POWER_W:g}" for t, read_c, power_w in rows]
    return "\n".join(["time [s],temperature [°C],duty [%]", *lines, ""])


RUNS = amount("records_identified")
TRUE = {"capacity_body": 16.7, "resistance_body": 14.7, "lag": 4.5, "delay": 1.3, "ambient": 20.0}


def values(found: Identified) -> dict[str, float]:
    return {each.parameter.key: each.value for each in found.found}


def told(found: Identified) -> dict[str, bool]:
    return {each.parameter.key: each.told for each in found.found}


def inside(found: Identified, key: str, true: float) -> bool:
    (each,) = (each for each in found.found if each.parameter.key == key)
    return each.low <= true <= each.high


def holds(found: Identified, true: dict[str, float]) -> None:
    for key, value in true.items():
        assert inside(found, key, value), key


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    hits = dict.fromkeys(TRUE, 0)
    for seed in range(RUNS):
        record = recorded(machine(noise=0.3), steps(), step_k=0.25, seed=seed)
        found = fit(record, Structure())
        for key, true in TRUE.items():
            hits[key] += inside(found, key, true)
    # Of 95 % intervals so few miss only once in a thousand times; for five parameters.
    least = int(binom.ppf(0.001 / len(TRUE), RUNS, 0.95))
    assert min(hits.values()) >= least, hits


@pytest.mark.parametrize(
    ("delay_s", "age_s", "share", "true"),
    [
        (2.0, 0.0, 1, TRUE | {"delay": 2.0}),
        (2.0, 0.75, 1, {"delay": 1.25}),  # the age of the readings is no dead time
        (2.0, 0.0, 2, {"capacity_body": 2 * 16.7}),
    ],
)
def test_a_record_without_noise_gives_the_numbers_back(
    delay_s: float, age_s: float, share: int, true: dict[str, float]
) -> None:
    record = recorded(machine(delay=delay_s), steps())
    record = Record(record.times_s, record.readings_c, record.powers_w * share)
    found = fit(record, Structure(), age_s=age_s)
    assert {key: values(found)[key] for key in true} == pytest.approx(true, rel=1e-4)
    assert found.rms_k < 1e-6 * np.ptp(found.record.readings_c)
    assert found.percent == pytest.approx(100)


def some(whole: Record, rows: Any) -> Record:
    times_s = whole.times_s[rows]
    return Record(times_s - times_s[0], whole.readings_c[rows], whole.powers_w[rows])


def at_odd_times() -> Record:
    whole = recorded(machine(noise=0.1), steps())
    rows = np.random.default_rng(3).random(whole.rows) < 0.6
    rows[[0, 20, 600]] = True  # the power is known only from row to row
    return some(whole, rows)


def made(duty: Any) -> Record:
    return recorded(machine(noise=0.1), duty)


RECORDS: dict[str, Callable[[], Record]] = {
    "full from the first row": lambda: made(steps(1000, (0, 1.0))),
    "on from the first row": lambda: made(steps(1000, (0, 0.3))),
    "begun as it heats": lambda: some(made(steps(1200, (20, 0.8), (500, 0.3))), slice(100, None)),
    "odd times": at_odd_times,
    "closed loop": lambda: made(np.clip(np.random.default_rng(5).normal(0.4, 0.3, 800), 0, 1)),
}


@pytest.mark.parametrize("name", RECORDS)
def test_any_record_will_do(name: str) -> None:
    holds(fit(RECORDS[name](), Structure()), TRUE)


def test_a_known_ambient_is_not_looked_for() -> None:
    found = fit(recorded(machine(noise=0.3), steps()), Structure(), ambient_c=20.0)
    (ambient,) = (each for each in found.found if each.given)
    assert (ambient.value, ambient.low, ambient.high) == (20.0, 20.0, 20.0)
    assert inside(found, "resistance_body", 14.7)


def test_two_bodies() -> None:
    network = machine(20.0, 2.0, 3.0, 0.5, noise=0.05, case=(100.0, 1.0))
    record = recorded(network, steps(3000, (20, 1.0), (1500, 0.3)))
    one, two = fit(record, Structure(1)), fit(record, Structure(2))
    assert any("--bodies 2" in warning for warning in one.warnings)
    assert two.warnings == ()
    true = {
        "capacity_body": 20.0, "resistance_body": 1.0, "capacity_shell": 100.0,
        "resistance_shell": 2.0, "lag": 3.0, "delay": 0.5, "ambient": 20.0,
    }  # fmt: skip
    holds(two, true)


@pytest.mark.parametrize(("begins_c", "said"), [(20.0, 0), (8.0, 1)])
def test_a_beginning_below_the_surroundings_is_doubted(begins_c: float, said: int) -> None:
    network = machine(noise=0.3).model_copy(update={"initial_c": begins_c})
    found = fit(recorded(network, steps()), Structure())
    doubts = [each for each in found.warnings if "colder than the ambient" in each]
    assert len(doubts) == said
    assert all("would have begun at 8" in each and "--cold" in each for each in doubts)


def test_a_record_too_short_for_the_losses_says_so() -> None:
    record = recorded(machine(noise=0.3), steps(40, (20, 1.0)))
    found = fit(record, Structure())
    assert told(found)["capacity_body"]
    assert not told(found)["resistance_body"]
    assert any("does not show the resistance body – ambient" in each for each in found.warnings)


def test_no_lag_and_no_dead_time_may_be_none() -> None:
    found = fit(recorded(machine(lag=0.0, delay=0.0, noise=0.3), steps()), Structure())
    assert not told(found)["delay"]
    assert inside(found, "lag", 0.0)
    assert values(found)["lag"] < 1.0  # one row


def test_single_garbled_readings_do_no_harm() -> None:
    record = recorded(machine(noise=0.3), steps(), seed=1)
    readings = record.readings_c.copy()
    readings[[50, 300, 700]] = 85.0, -127.0, 0.0
    found = fit(Record(record.times_s, readings, record.powers_w), Structure())
    assert np.flatnonzero(found.left_out).tolist() == [50, 300, 700]
    holds(found, TRUE)
    assert found.warnings[-1].endswith(": 3")


def test_a_heater_that_cools_fits_no_machine() -> None:
    record = recorded(machine(), steps())
    upside_down = Record(record.times_s, 100 - record.readings_c, record.powers_w)
    with pytest.raises(Unusable, match="gets no warmer"):
        fit(upside_down, Structure())


def test_the_lag_is_the_shorter_time() -> None:
    record = recorded(machine(1.0, 2.0, 300.0, 2.0), steps(2000, (20, 1.0)))
    found = values(fit(record, Structure()))
    assert found["lag"] == pytest.approx(2.0, rel=1e-3)
    assert found["capacity_body"] * found["resistance_body"] == pytest.approx(300, rel=1e-3)


EPS = float(np.finfo(float).eps)


def exact(record: Record) -> float:
    """What rounding may do along eigenvectors of the worst condition, and the least lag, K."""
    steepest = float(np.abs(np.diff(record.readings_c)).max(initial=0.0)) / float(record.times_s[1])
    return WORST_CONDITION * EPS * (20 + float(np.ptp(record.readings_c))) + LEAST_LAG_S * steepest


def answered(
    network: ThermalNetwork, record: Record, delay_s: float, start_c: Series | None = None
) -> Series:
    return Answer(record, 0.0).readings(modes(network, "heater", "sensor"), delay_s, 20.0, start_c)


MACHINES = st.builds(
    machine, st.integers(1, 5000), st.integers(1, 50), st.integers(0, 200), st.integers(0, 20)
)


@given(network=MACHINES, duty=st.lists(st.floats(0, 1), min_size=2, max_size=60))
@example(network=machine(10.0, 2.0, 3.0, 4.0, case=(50.0, 1.0)), duty=steps().tolist())
def test_it_answers_as_the_plant(network: ThermalNetwork, duty: list[float]) -> None:
    record = recorded(network, duty)
    found = answered(network, record, network.sense["sensor"].delay_s)
    assert found == pytest.approx(record.readings_c, rel=0, abs=exact(record))


@pytest.mark.parametrize("lag", [16.7 * 14.7, 16.7 * 14.7 * (1 + 1e-9)])
def test_equal_time_constants_have_no_modes_but_an_answer(lag: float) -> None:
    network = machine(lag=lag)
    record = recorded(network, steps())
    moved_k = float(np.ptp(record.readings_c))
    # A relative change of a time constant moves no step response by more than its share.
    found = answered(network, record, 1.3)
    assert found == pytest.approx(record.readings_c, rel=0, abs=8 * APART * moved_k + exact(record))


def test_a_start_that_is_not_at_rest_dies_away() -> None:
    network = machine(lag=0.0, delay=0.0)
    record = recorded(network, np.zeros(500))
    found = answered(network, record, 0.0, np.array([100.0, 100.0]))
    expected = 20 + 80 * np.exp(-record.times_s / (16.7 * 14.7))
    assert found == pytest.approx(expected, rel=0, abs=100 * WORST_CONDITION * EPS)
