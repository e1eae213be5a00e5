"""A year of steady holding on this computer: what is healthy does not trip. The generated C of one
loop, with the protections that a new user gets, holds a setpoint in a small world in C (`year.c`):
the plant that the specification gives, in exact steps, weather, mains, the sensor's noise and its
steps. That the same C decides as the reference does is held beside it."""

from functools import cache
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import numpy as np
import pytest
from cffi import FFI
from courses.host_reference import Way
from host_control import run_problem
from host_specs import build_of_spec
from numpy.typing import NDArray
from rig.firmware import made, spec_of, whole
from scipy.stats import norm
from suite import SEED, amount

import heatwright.sim.host
from heatwright.cli.tune.task import task_of
from heatwright.sim.bench import bench
from heatwright.sim.circuits import shares
from heatwright.sim.device import AvrDevice
from heatwright.sim.host import Host
from heatwright.sim.host.firmware import INPUT
from heatwright.sim.host.layout import declarations
from heatwright.sim.plants import powers_of
from heatwright.sim.plants.thermal_network import Plant, step_matrix
from heatwright.sim.replay import replay
from heatwright.sim.tuning.process import reading_age_s
from heatwright.sim.tuning.rules import lambda_rule, simc
from heatwright.spec import Analog, Controller, Event, Rtd, Spec, Thermistor

HERE, HOST = Path(__file__).parent, Path(heatwright.sim.host.__file__).parent
AMBIENT_C, DAY_K, SEASON_K = 20.0, 5.0, 8.0
SUPPLY = 0.1
COLDEST = 0.75  # the coldest time, as a share of the year from spring on
FAR_K_PER_W = 0.5  # from the load to the room
LOWEST_C = 40.0  # warmer than the warmest day: there heat is needed to hold
EXACTLY_C = 85.0  # what a DS18B20 says that has never measured


class Kind(NamedTuple):
    """A sensor, and how far its machine goes."""

    text: str
    highest_c: float
    low: bool = False  # it reads what `protection.minimum` is by default; else `check` asks for one


_SPI = "chip_select: D10, clock: D13, data_out: D12"
KINDS = {
    "analog": Kind(
        "pin: A1, scale: 10 mV/K, reference: internal, range: 2 °C .. 105 °C, oversample: 16", 85
    ),
    "ds18b20": Kind("pin: A1", 105, low=True),
    "max31855": Kind(f"{_SPI}, thermocouple: K", 900, low=True),
    "max31856": Kind(f"{_SPI}, data_in: D11", 1000, low=True),
    "max6675": Kind(_SPI, 800),
    "rtd": Kind(
        "pin: A1, element: pt100, reference: 3.3 V, range: 2 °C .. 262 °C, oversample: 16, "
        "amplifier: {gain: 33.33, excitation: 3.3 V, series: 3.3 kΩ}", 220
    ),
    "thermistor": Kind(
        "pin: A1, divider: {pull_up: 4.7 kΩ}, range: 0 °C .. 300 °C, oversample: 16, "
        "curve: {resistance: 100 kΩ, at: 25 °C, beta: 3950 K}", 250
    ),
}  # fmt: skip


class Style(NamedTuple):
    """A machine, by what it can do, and how it is held."""

    excess: float  # full power, as a multiple of what holds the highest setpoint on a usual day
    lag_s: float  # in which the machine comes near where it ends
    noisy: bool
    heater: str
    algorithm: str


STYLES = {
    "slow": Style(4, 7200, False, "kind: time_proportional, window: 2 s", "pid"),
    "quick": Style(1.8, 600, True, "kind: pwm, frequency: 490 Hz", "pid"),
    "switched": Style(2, 1800, True, "kind: digital", "{kind: on_off}"),
    "cooled": Style(2, 1800, False, "kind: digital", "{kind: three_position, dead_band: 2 K}"),
}
SPECIFIED = """
heatwright: 1
controller: {{name: year, board: nano}}
sensors: {{felt: {{kind: {kind}, {sensor}}}}}
outputs:
  heater: {{{heater}, pin: D3, power: {power_w} W}}
  {cooler}
loops:
  held:
    {{sensor: felt, heater: heater, {cooled} period: 1 s, algorithm: {algorithm},
     setpoint: {{initial: {initial_c} °C, minimum: {lowest_c} °C, maximum: {highest_c} °C}},
     protection: {{{minimum}}}}}
safety: {{watchdog: 250 ms}}
interfaces: [{{kind: serial_plotter, loop: held, baud: 9600}}]
simulation:
  ambient: {ambient_c} °C
  plant:
    kind: thermal_network
    nodes: {{element: {element} J/K, load: {load} J/K}}
    links:
      - {{between: [element, load], resistance: {near} K/W}}
      - {{between: [load, ambient], resistance: {far} K/W}}
    heat: {{heater: element}}
    sense: {{felt: {{node: load, lag: {sensor_lag} s, noise: {noise_k} K}}}}
    {effect}
  scenario: [{{for: 10 min}}]
"""


@cache
def specified(kind: str, style: str, initial_c: float = LOWEST_C) -> str:
    """Write the machine down as a new user does: no word of its protections; gains by `tune`."""
    sensor, made_so = KINDS[kind], STYLES[style]
    cooler = style == "cooled"
    tuned = made_so.algorithm == "pid"
    words: dict[str, Any] = {
        "kind": kind, "sensor": sensor.text, "heater": made_so.heater,
        "power_w": made_so.excess * (sensor.highest_c - AMBIENT_C) / FAR_K_PER_W,
        "cooler": "cooler: {kind: digital, pin: D4}" if cooler else "",
        "cooled": "cooler: cooler," if cooler else "",
        "effect": "fans: {cooler: {link: [load, ambient], factor: 3}}" if cooler else "",
        "initial_c": initial_c, "lowest_c": LOWEST_C, "highest_c": sensor.highest_c,
        "ambient_c": AMBIENT_C,
        "minimum": "" if sensor.low else "minimum: 5.5 °C",
        "algorithm": "{kind: pid, kp: 1, ki: 0.01}" if tuned else made_so.algorithm,
        "load": made_so.lag_s / FAR_K_PER_W, "far": FAR_K_PER_W,
        "element": made_so.lag_s / FAR_K_PER_W / 50, "near": FAR_K_PER_W / 25,
        "sensor_lag": made_so.lag_s / 300, "noise_k": 0,
    }  # fmt: skip
    spec = spec_of(SPECIFIED.format(**words))
    if made_so.noisy:
        step_k = spec.controller.sensors["felt"].step_at_k(sensor.highest_c, "atmega328p")
        words["noise_k"] = round(step_k / 2, 3)
    if tuned:
        task = task_of(spec, "held", at_c=sensor.highest_c, lambda_s=None, tauc_s=None)
        found = {"slow": lambda_rule, "quick": simc}[style](task.model, task.filter_s)
        kept = {"kp": found.kp, "ki": found.ki, "kd": found.kd}
        gains = ", ".join(f"{name}: {value:.4g}" for name, value in kept.items())
        filtered = f", derivative_filter: {found.filter_s:.4g} s" if found.kd else ""
        words["algorithm"] = f"{{kind: pid, {gains}{filtered}}}"
    return SPECIFIED.format(**words)


COMPILE = "gcc -std=c11 -O2 -Wall -Wextra -Werror -fPIC -shared year.c -lm -o year.so"
YEAR_S = 365 * 86400
SETTLED = 0.5  # share of each run, at the end: there it is held
MOST_EDGES = 2**18
NONE = np.zeros(0, INPUT)
FUNCTIONS = {"set": "host_set", "tick": "loop_held_tick", "state": "host_state"}


@cache
def _year() -> tuple[Any, Any]:
    """Compile the world; return what cffi knows of it, and the world."""
    texts = {path.name: path.read_text("utf-8") for path in HERE.glob("year.[ch]")}
    texts["world.h"] = (HOST / "world.h").read_text("utf-8")
    ffi = FFI()
    lines = texts["year.h"].splitlines()
    ffi.cdef("struct host_input;" + "\n".join(each for each in lines if each[:1] != "#"))
    return ffi, ffi.dlopen(str(made(COMPILE.split(), texts, "year.so")))


def _edges(controller: Controller) -> tuple[NDArray[np.float64], int, int]:
    """Temperatures at which the sensor's code changes, rising; the code below, the step of each."""
    sensor = controller.thermometers["felt"]
    highest_c = controller.loops["held"].protection.maximum_c + 1
    if not isinstance(sensor, Analog | Rtd | Thermistor):
        steps = np.arange(highest_c // sensor.step_k) + 1
        return (steps - 0.5) * sensor.step_k, 0, 1
    celsius = np.linspace(*sensor.range_c, MOST_EDGES)
    codes = np.floor(1024 * np.asarray(shares(sensor, controller.board, celsius))).astype(int)
    changes = np.flatnonzero(np.diff(codes))
    assert set(np.abs(np.diff(codes))) == {0, 1}
    return celsius[changes + 1], int(codes[0]), int(np.sign(codes[-1] - codes[0]))


class World:
    def __init__(self, spec: Spec) -> None:
        ffi, _ = _year()
        self.host = Host(build_of_spec(spec, sanitized=False))
        controller = spec.controller
        simulation, loop = controller.simulated, controller.loops["held"]
        network, sensor = simulation.plant, controller.thermometers["felt"]
        firmware = declarations(self.host.build.project, self.host.build.parts)
        self._machine = machine = ffi.new("struct year_machine *")
        machine.set, machine.tick, machine.state = (
            ffi.cast(
                ffi.typeof(getattr(machine, what)),
                int(firmware.cast("uintptr_t", firmware.addressof(self.host.library, function))),
            )
            for what, function in FUNCTIONS.items()
        )
        machine.full_w, machine.period_s = powers_of(controller)[loop.heater], loop.period_s
        machine.period_ticks = round(loop.period_s * 100)
        plant = Plant(network, powers_of(controller), ambient_c=AMBIENT_C, step_s=loop.period_s)
        self._highest_c = loop.setpoint.maximum_c
        machine.states = len(network.nodes) + 1
        for cools in (0, 1):
            rates = plant.rates((float(cools),) * len(network.fans))
            rows = step_matrix(rates, machine.states, loop.period_s)
            for number, row in enumerate(rows):
                machine.step[cools][number][0 : len(row)] = row.tolist()
        machine.felt = plant.state_of("felt")
        late_s = network.sense["felt"].delay_s + reading_age_s(controller, "felt")
        machine.late_steps = late_s / loop.period_s
        machine.noise_k = network.sense["felt"].noise_k
        edges, machine.lowest_code, machine.code_step = _edges(controller)
        machine.codes, machine.oversample = len(edges), getattr(sensor, "oversample", 1)
        normals = norm.ppf((np.arange(2**10) + 0.5) / 2**10) / 2**0.5
        self._kept = edges, normals  # for as long as the machine points to them
        machine.edges_c, machine.normals = (
            ffi.cast("double *", each.ctypes.data) for each in self._kept
        )
        machine.ambient_c, machine.day_k, machine.season_k = AMBIENT_C, DAY_K, SEASON_K
        machine.supply = SUPPLY
        places = {name: place for name, (_, place) in (self.host.type.fields or {}).items()}
        machine.duty_at, machine.fault_at = places["duty_percent"], places["fault.code"]
        machine.cooling_at = places.get("cooling", 0)

    def hold(self, setpoint_c: float, steps: int, seed: str, inputs: NDArray[Any] = NONE) -> Any:
        """Hold a setpoint from cold: the highest in the coldest days, else from any day on. What
        goes into the first steps is written to `inputs`."""
        ffi, library = _year()
        random = Random(f"year {SEED} {seed}")  # noqa: S311 - no secret
        self.host.renew()
        coldest = setpoint_c == self._highest_c
        lasting_s = steps * self._machine.period_s
        self._machine.start_s = (
            COLDEST * YEAR_S - lasting_s / 2 if coldest else random.random() * YEAR_S
        )
        told = ffi.new("struct year_told *")
        kept = ffi.cast("struct host_input *", inputs.ctypes.data)
        settled = round(steps * SETTLED)
        number = 1 + random.getrandbits(60)
        library.year(self._machine, setpoint_c, steps, settled, number, len(inputs), kept, told)
        return told


def setpoints(kind: str, style: str) -> list[float]:
    """Return those of the sensor's ten that this machine holds; 85 °C is one of each."""
    spread = np.linspace(LOWEST_C, KINDS[kind].highest_c, 9).round(1).tolist()
    return [*spread[list(STYLES).index(style) :: len(STYLES)], EXACTLY_C]


MACHINES = [(kind, style) for kind in KINDS for style in STYLES]


@pytest.mark.parametrize(("kind", "style"), MACHINES)
def test_nothing_trips(kind: str, style: str) -> None:
    spec, steps = spec_of(specified(kind, style)), amount("year_hours") * 3600
    runaway = spec.controller.loops["held"].protection.runaway
    assert runaway is not None
    world = World(spec)
    for setpoint_c in setpoints(kind, style):
        told = world.hold(setpoint_c, steps, f"{kind} {style} {setpoint_c}")
        assert told.fault == 0, (setpoint_c, told.steps)
        assert setpoint_c - runaway.above_k < told.least_c
        assert told.most_c < setpoint_c + runaway.above_k


@pytest.mark.parametrize(("kind", "style"), MACHINES)
def test_its_firmware_is_the_reference(kind: str, style: str) -> None:
    spec = spec_of(specified(kind, style))
    world, inputs = World(spec), np.zeros(amount("year_steps_compared"), INPUT)
    world.hold(EXACTLY_C, len(inputs), style, inputs)
    assert len(set(inputs["reading_raw"])) > 1
    wanted = Way(spec.controller).expected(inputs, world.host.type)
    assert run_problem(world.host, inputs, wanted) == ""


SAMPLED = ("ds18b20", Random(f"year {SEED}").choice(sorted({*KINDS} - {"ds18b20"})))  # noqa: S311
"""The one that says 85 °C when it has never measured, and any other."""


@pytest.mark.parametrize("kind", SAMPLED)
def test_nor_does_the_binary_with_its_sensor(kind: str) -> None:
    text = specified(kind, "quick", EXACTLY_C)
    controller = spec_of(text).controller
    hours = amount("year_hours_binary")
    hold = Event.model_validate({"for": f"{hours} h"})
    log = bench(controller, AvrDevice(controller, whole(text)), [hold]).steps["held"]
    assert set(log["fault.code"]) == {0}
    held = log[len(log) // 2 :]
    assert held["temperature_c"].min() <= EXACTLY_C <= held["temperature_c"].max()
    assert replay(controller, log).mismatches == 0
