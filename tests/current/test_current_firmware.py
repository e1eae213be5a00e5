"""From a current to what the firmware takes it for, and what the limiter then holds. Faults of the
sensor; what is timed with it. The README says how slow the filter of a pulsed current may be, and
`check` goes by the same. Whatever the wire, the limiter holds the root mean square that follows
from its duty."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig.firmware import changed, controller_of, example, files_of, spec_of, whole
from rig.sensors import KEYS, bed

from heatwright.sim.binary.elf import Elf
from heatwright.sim.chain import chain_errors
from heatwright.sim.device import AvrDevice
from heatwright.sim.faults import catalogue, try_fault
from heatwright.sim.faults.world import Site
from heatwright.sim.reference.numbers import Single
from heatwright.sim.reference.protection.limiter import Limiter
from heatwright.sim.reference.sensors.current import Converter, IdealSensor
from heatwright.sim.timing.stage import Stage
from heatwright.spec import CurrentSensor, SpecError, load_text

SPEC = """
heatwright: 1
controller: {name: measured, board: BOARD}
sensors:
  air: {THERMOMETER}
  amps: {kind: current, SENSOR}
outputs:
  heater: {kind: digital, pin: D3, power: 60 W, supply: 24 V, current: {sensor: amps, trip: 4 A}}
loops:
  air:
    {sensor: air, heater: heater, period: 1 s, algorithm: {kind: on_off, hysteresis: 2 K},
     setpoint: {initial: 25 °C, minimum: 20 °C, maximum: 70 °C},
     protection: {rising_while_off: off, heating: off, frozen: off}}
safety: {self_checks: false}
"""
BOARDS = {"uno": "kind: ds18b20, pin: D2", "mega2560": "kind: ds18b20, pin: D22"}
CIRCUITS = {
    "shunt": "pin: A1, scale: 0.2 V/A", "once": "pin: A1, scale: 1 V/A, oversample: 1",
    "most": "pin: A3, scale: 0.5 V/A, oversample: 32",
    "hall": "pin: A1, scale: 0.185 V/A, offset: 2.5 V, oversample: 16",
    "odd": "pin: A2, scale: 0.4 V/A, offset: 0.333 V, oversample: 7, reference: 3.3 V",
    "internal": "pin: A1, scale: 0.1 V/A, reference: internal", "far": "pin: A13, scale: 0.2 V/A",
}  # fmt: skip
"""What a spec says of the sensor; `far` is on a channel beyond MUX5."""


def text_of(circuit: str) -> str:
    board = "mega2560" if circuit == "far" else "uno"
    text = SPEC.replace("THERMOMETER", BOARDS[board]).replace("BOARD", board)
    return text.replace("SENSOR", CIRCUITS[circuit])


class Measured:
    def __init__(self, circuit: str, elf: Elf | None = None) -> None:
        self.controller = controller_of(text_of(circuit))
        self.device = AvrDevice(self.controller, elf or whole(text_of(circuit)))
        sensor = self.controller.sensors["amps"]
        assert isinstance(sensor, CurrentSensor)
        self.sensor = sensor
        self.law = Converter(sensor, self.controller.board)
        self.device.sense("air", 60.0)
        self._now_s = 0.02  # steps are at whole seconds and the first tick's microseconds

    def step(self, amperes: float) -> None:
        """Let a current flow for a period; the step that ends it is done."""
        self.device.sense("amps", amperes)
        self._now_s += 1.0
        self.device.advance(self._now_s)

    def run_on(self, seconds: float) -> None:
        """Go on for less than a period, then to its end with the next step."""
        self.device.advance(self._now_s + seconds)

    @property
    def raw(self) -> int:
        return int(self.device.read("current_heater.raw"))

    @property
    def amperes(self) -> float:
        return float(self.device.read("current_heater.amperes"))


@pytest.mark.parametrize("circuit", CIRCUITS)
def test_the_chain_is_exact_to_one_step(circuit: str) -> None:
    (found,) = chain_errors(controller_of(text_of(circuit)), whole(text_of(circuit)))
    assert found.passed
    assert found.measures == "current"
    assert found.chain_steps <= 0.5 + 1e-3  # a line has no error of its own
    assert found.as_json()["rows"][0]["current"] == 0.0


@pytest.fixture
def hall() -> Measured:
    return Measured("hall")


@pytest.mark.parametrize("circuit", CIRCUITS)
def test_it_reads_what_flows(circuit: str) -> None:
    it_reads_what_flows(Measured(circuit))


def it_reads_what_flows(bench: Measured) -> None:
    ideal = IdealSensor(bench.sensor, bench.controller.board)
    for amperes in (0.0, 1.0, 0.013, 3.9, 2.5, 0.0):  # below what trips
        bench.step(amperes)
        assert bench.raw == ideal.read(amperes)[1]
        assert np.float32(bench.amperes) == bench.law(bench.raw)
        assert bench.amperes == pytest.approx(amperes, abs=0.5001 * bench.law.step_a)


def test_a_reading_is_of_the_last_moments_before_the_step(hall: Measured) -> None:
    """One code may be missed, so its sixteen are of the last 17 ticks but the last one."""
    ideal = IdealSensor(hall.sensor, hall.controller.board)
    before, after = (ideal.read(amperes)[1] // 16 for amperes in (3.0, 1.0))
    for late in (1, 2, 3, 10, 17, 18, 19):
        hall.step(3.0)
        hall.run_on(0.98 - (late - 0.5) * 0.01)
        hall.step(1.0)
        took = min(max(late - 2, 0), 16)
        assert hall.raw == before * (16 - took) + after * took, late


def test_a_current_below_the_scale_is_none(hall: Measured) -> None:
    hall.step(-1.0)
    assert hall.raw < 16 * 512
    assert hall.amperes == 0.0


def test_an_adc_that_hangs_leaves_the_last_current(hall: Measured) -> None:
    """Also when it hangs with some codes taken."""
    for late_s in (0.0, 0.9):
        hall.step(1.0)
        before = hall.raw
        hall.device.sense("amps", 3.0)
        hall.run_on(late_s)
        hall.device.avr.adc.fail(hung=True)
        hall.step(3.0)
        assert hall.raw == before
        hall.device.avr.adc.fail()
        hall.step(3.0)
        assert hall.amperes == pytest.approx(3.0, abs=hall.law.step_a)


def test_a_line_that_is_off_is_found() -> None:
    elf = whole(text_of("shunt"))
    at = elf.symbols["sensor_amps_line"]
    worse = np.array([1.0], "<f4").tobytes()
    elf.flash = elf.flash[:at] + worse + elf.flash[at + 4 :]
    (found,) = chain_errors(controller_of(text_of("shunt")), elf)
    assert not found.passed


PID = "algorithm: {kind: pid, kp: 12, ki: 0.1, kd: 60, derivative_filter: 2 s}"
TRIPPED = "kind: digital, current: {sensor: amps, trip: 12 A}"


@pytest.fixture(scope="module")
def site() -> Site:
    """A heater whose current trips; the fabricator's is limited, and `verify` proves that."""
    text = changed(
        bed("hotend", interface=KEYS),
        ("\noutputs:", "\n  amps: {kind: current, pin: A2, scale: 0.25 V/A}\noutputs:"),
        ("kind: pwm, pin: D3, frequency: 490 Hz, power: 120 W",
         f"{TRIPPED}, pin: D3, power: 240 W, supply: 24 V"),
        (PID, "algorithm: {kind: on_off, hysteresis: 1 K}"),
        ("within: 60 s", "within: 300 s"),  # Stage swings it about one temperature
        ("bears: {plate: 100 °C}", "bears: {plate: 280 °C}"),
        ("lag: 4 s}", "lag: 4 s}, amps: {of: heater, lag: 20 ms}"),
    )  # fmt: skip
    return Site(spec_of(text).controller, "bed", whole(text))


RULES = {
    "current_sensor_torn": "no_current",
    "current_sensor_at_supply": "over_current",
    "current_sensor_stands": "current_while_off",
}


@pytest.mark.parametrize(("name", "rule"), RULES.items())
def test_it_trips(site: Site, name: str, rule: str) -> None:
    found = {fault.id: fault for fault in catalogue(site.controller, site.program)}
    result = try_fault(found[name])
    assert (result.detail, result.rule) == ("", rule)


def test_it_is_timed_while_it_heats(site: Site) -> None:
    device = AvrDevice(site.controller, site.program)
    stage, on_s = Stage(site.controller, device, 600.0), 0
    stage.advance(5.0)
    device.press("up")
    for second in range(6, 110):
        stage.advance(second)
        device.press(None)
        on_s += device.read("current_heater.applied_percent") > 0
        assert not device.read("fault.code")
    assert on_s >= 30


@pytest.mark.parametrize("name", ["fabricator", "dryer"])
def test_what_a_master_switches_is_on(name: str) -> None:
    controller = example(name).controller
    device = AvrDevice(controller, whole(name))
    Stage(controller, device, 60.0).advance(60.0)
    ((loop, _),) = controller.loops.items()
    assert device.read(f"loop_{loop}.enabled") == 1
    assert not device.read("fault.code")


KINDS = {"limited": "limit: 3 A", "only watched": "trip: 3.75 A"}
TENTH_MS = 1e-4


def with_lag(text: str, lag_s: float) -> str:
    return changed(text, ("current: {of: heater}", f"current: {{of: heater, lag: {lag_s:.4f} s}}"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_slowest_filter_that_it_names_is_allowed_and_no_slower_one(kind: str) -> None:
    text = changed("fabricator", ("limit: 3 A", KINDS[kind]))
    (told,) = re.findall(r"through an RC of ([\d.]+) s to ([\d.]+) s", files_of(text)["README.md"])
    fastest_s, slowest_s = map(float, told)
    assert fastest_s == 5 / 1000
    load_text(with_lag(text, slowest_s), "spec.yaml")
    with pytest.raises(SpecError, match="does not follow the current"):
        load_text(with_lag(text, slowest_s + TENTH_MS), "spec.yaml")


SUPPLY_V, LIMIT_A = 43.0, 3.0
RATED = {True: 25.57, False: SUPPLY_V}
SMALL = st.floats(0.001, 5.0)  # duties whose current is about what counts as one, %
ASKED = st.lists(st.one_of(SMALL, st.floats(5.0, 100.0), st.just(100.0)), min_size=8, max_size=40)


class Wire:
    """A wire behind a limiter, measured in each step under the duty of the step before."""

    def __init__(self, ohm: float, *, rated: bool, text: str = "") -> None:
        plain = "fabricator" if rated else changed("fabricator", (", rated: 25.57 V", ""))
        self._controller = controller_of(text or plain)
        self.limiter = Limiter(self._controller, self._controller.loops["nozzle"])
        sensor = self._controller.sensors["current"]
        self._meter = IdealSensor(sensor, self._controller.board)  # type: ignore[arg-type]
        self._full_share = (RATED[rated] / SUPPLY_V) ** 2
        self._peak_a = SUPPLY_V / ohm
        self._duty = 0.0

    @property
    def rms_a(self) -> float:
        """What it has to bear under the present duty."""
        return math.sqrt(self._duty / 100 * self._full_share) * self._peak_a

    @property
    def mean_a(self) -> float:
        return self._duty / 100 * self._full_share * self._peak_a

    def ask(self, percent: float) -> bool:
        _, raw = self._meter.read(self.mean_a)
        self.limiter.measure(raw, Single(self._duty))
        code = self.limiter.watch()
        self._duty = min(percent, float(self.limiter.top_percent))
        return code == 20

    def bound_a(self, held_a: float) -> float:
        """The limit, as far as half a step of the ADC lets the smallest current tell it."""
        half_a = self.limiter.amperes_of.step_a / 2
        return LIMIT_A * (1 + half_a / held_a) * (1 + 1e-6)


@given(asked=ASKED, ohm=st.floats(0.5, 40.0), rated=st.booleans())
def test_no_wire_bears_more_than_the_limit_for_longer_than_a_step(
    asked: list[float], ohm: float, rated: bool
) -> None:
    """It trips, or the step after the first too much has less."""
    wire = Wire(ohm, rated=rated)
    held_a = LIMIT_A**2 / (SUPPLY_V / ohm)
    beyond = 0
    for percent in asked:
        if wire.ask(percent):
            return
        beyond = beyond + 1 if wire.rms_a > wire.bound_a(held_a) else 0
        assert beyond <= 1


@pytest.mark.parametrize("rated", [True, False])
@pytest.mark.parametrize("ohm", [4.0, 6.0, 8.0, 12.0, 30.0])
def test_the_limit_is_used_up(ohm: float, rated: bool) -> None:
    """Asked for all, a wire has full duty or the limit, to what half a step of the ADC tells."""
    wire = Wire(ohm, rated=rated)
    for _ in range(8):
        assert not wire.ask(100.0)
    full_a = RATED[rated] / ohm
    expected_a = min(full_a, LIMIT_A)
    half_a = wire.limiter.amperes_of.step_a / 2
    assert wire.rms_a == pytest.approx(expected_a, rel=1.01 * half_a / wire.mean_a)


@pytest.mark.parametrize("rated", [True, False])
def test_a_duty_too_small_to_be_measured_leaves_the_way_up_open(rated: bool) -> None:
    """A healthy wire goes on from a quarter, after hours of a duty that shows no current."""
    wire = Wire(8.54, rated=rated)
    for _ in range(50):
        wire.ask(0.01)
    duties = []
    for _ in range(5):
        wire.ask(100.0)
        duties.append(float(wire.limiter.top_percent))
    assert duties[0] == 25.0
    assert wire.rms_a == pytest.approx(LIMIT_A, rel=0.01)


def test_a_wire_of_too_little_resistance_trips_in_the_second_step() -> None:
    """With a fifth of it, the mean at a quarter of full duty is what 3.75 A have at all of it."""
    for ohm, trips in ((1.65, True), (1.75, False)):
        wire = Wire(ohm, rated=True)
        assert not wire.ask(100.0)
        assert wire.ask(100.0) is trips


@pytest.mark.parametrize("scale", ["38 mV/A", "40 mV/A", "60 mV/A"])
def test_what_check_allows_of_a_coarse_sensor_is_told_from_none(scale: str) -> None:
    """A wire that almost trips is held, and not sent back to its first duty by a low reading."""
    text = changed("fabricator", (", rated: 25.57 V", ""), ("0.5 V/A", scale))
    for ohm in (2.9, 2.95, 3.0, 3.2, 3.5, 4.0):
        wire = Wire(ohm, rated=False, text=text)
        duties = []
        for _ in range(100):
            assert not wire.ask(100.0)
            duties.append(float(wire.limiter.top_percent))
        assert duties[0] == 25.0
        assert max(duties[1:]) < 12.5
