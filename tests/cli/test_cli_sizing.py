"""Walls and wires by hand and by textbooks; the reserve by the simulated machine itself."""

import math
from pathlib import Path

import pytest
from rig.commands import Heatwright
from rig.firmware import EXAMPLE_NAMES, changed, controller_of

from heatwright.sim.plants import FOREVER_S, plant_of, powers_of
from heatwright.spec import Controller
from heatwright.spec.outputs import always_running
from heatwright.spec.physics.reserve import RECOMMENDED, reserves, small_reserves
from heatwright.spec.physics.sized import cross_flow_film_w_per_m2k, sized_wall, sized_wire
from heatwright.spec.physics.sized import wind_film_w_per_m2k as wind_film
from heatwright.spec.physics.sizing import Wall, Wire

SIGMA = 5.670374419e-8
PLASTIC = {"thickness": "3 mm", "conductivity": "0.2 W/(m·K)"}
CHAMBER = {
    "area": "0.665 m²", "layers": [PLASTIC], "inside": "8.7 W/m²K", "outside": "8.7 W/m²K",
    "emissivity": 0.85,
}  # fmt: skip
WIRE = {
    "resistivity": "1.1 Ω·mm²/m", "surface_load": "2 W/cm²", "voltage": "24 V",
    "air_speed": "2 m/s", "measured": "127 °C",
}  # fmt: skip

LESS = "\n      output: {maximum: 80 %}\n"


def test_the_builders_walls_within_his_digits() -> None:
    """His R1 and R3, and 165 W with the wall's resistance d/(λ·S) in the place of λ·d/S."""
    found = sized_wall(Wall.model_validate(CHAMBER), 70.0, 20.0)
    assert found.inside_k_per_w == pytest.approx(0.173, abs=0.0005)
    assert found.layers_k_per_w == pytest.approx(0.003 / (0.2 * 0.665))
    assert found.outside_k_per_w == pytest.approx(0.107, abs=0.0005)
    assert found.loss_w == pytest.approx(165, abs=0.5)


@pytest.mark.parametrize("change", [{}, {"emissivity": 0}, {"outside": None, "wind": "8 m/s"}])
def test_what_comes_through_is_what_leaves(change: dict[str, object]) -> None:
    """Kirchhoff at the surface, and two layers in a row."""
    given = {**CHAMBER, "layers": [PLASTIC, PLASTIC], **change}
    wall = Wall.model_validate({key: value for key, value in given.items() if value is not None})
    found = sized_wall(wall, 70.0, 20.0)
    film = 8.7 if wall.wind_m_per_s is None else wind_film(8.0)
    hot_k = found.surface_c + 273.15
    leaves_w = film * (hot_k - 293.15) + wall.emissivity * SIGMA * (hot_k**4 - 293.15**4)
    assert found.loss_w == pytest.approx(0.665 * leaves_w, rel=1e-9)
    through_w = (70 - found.surface_c) / (1 / (8.7 * 0.665) + 2 * 0.003 / (0.2 * 0.665))
    assert found.loss_w == pytest.approx(through_w, rel=1e-9)


def test_wind_is_as_in_mcadams_table_and_has_no_step() -> None:
    assert wind_film(0.0) == pytest.approx(5.62, abs=0.005)
    assert wind_film(1.0) - wind_film(0.0) == pytest.approx(3.91, abs=0.005)
    assert wind_film(4.8767) == pytest.approx(wind_film(4.8769), rel=0.001)
    assert wind_film(10.0) == pytest.approx(7.17 * 10**0.78, rel=0.001)


def test_a_cylinder_of_a_textbook() -> None:
    """Incropera & DeWitt, example 7.4: 12.7 mm, 128.4 °C in air of 26.2 °C at 10 m/s: 96 W/m²K."""
    film = cross_flow_film_w_per_m2k(0.0127, 10.0, (128.4 + 26.2) / 2)
    assert film == pytest.approx(96, rel=0.01)


@pytest.mark.parametrize("emissivity", [0.0, 0.9])
def test_a_wire_has_its_power_its_load_and_the_temperature_of_both(emissivity: float) -> None:
    wire = Wire.model_validate({**WIRE, "emissivity": emissivity})
    found = sized_wire(wire, 240.0, 24.0, 20.0)
    diameter_m = found.diameter_mm / 1000
    ohm = 1.1e-6 * found.length_m / (math.pi * diameter_m**2 / 4)
    assert (ohm, found.current_a) == (pytest.approx(2.4), 10.0)
    surface_m2 = math.pi * diameter_m * found.length_m
    assert 240 / surface_m2 == pytest.approx(2e4)
    film = cross_flow_film_w_per_m2k(diameter_m, 2.0, (found.temperature_c + 20) / 2)
    radiated = emissivity * SIGMA * ((found.temperature_c + 273.15) ** 4 - 293.15**4)
    assert film * (found.temperature_c - 20) + radiated == pytest.approx(2e4)


def test_the_load_that_ends_as_measured_does() -> None:
    found = sized_wire(Wire.model_validate(WIRE), 240.0, 24.0, 20.0)
    load = found.load_as_measured_w_per_cm2
    assert load is not None
    again = sized_wire(
        Wire.model_validate({**WIRE, "surface_load": f"{load!r} W/cm²"}), 240.0, 24.0, 20.0
    )
    assert again.temperature_c == pytest.approx(127.0, abs=1e-6)
    assert sized_wire(Wire.model_validate(WIRE), 240.0, 24.0, 130.0)[-1] is None


def settled_c(controller: Controller, loop: str, power_w: float) -> float:
    """The loop's sensor in the simulated machine without its noise, after years at a power."""
    simulation, heater = controller.simulation, controller.loops[loop].heater
    assert simulation is not None
    still = {
        name: sense.model_copy(update={"noise_k": 0.0})
        for name, sense in simulation.plant.sense.items()
    }
    network = simulation.plant.model_copy(update={"sense": still})
    machine = plant_of(controller, network, ambient_c=simulation.ambient_c, step_s=FOREVER_S)
    running = dict.fromkeys(controller.outputs, 0.0) | dict.fromkeys(
        always_running(controller.outputs), 1.0
    )
    for _ in range(200):  # radiation is taken anew in every step
        machine.step(running | {heater: power_w / powers_of(controller)[heater]})
    return machine.sensed_c()[controller.loops[loop].sensor]


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_the_needed_power_ends_at_the_highest_setpoint(name: str) -> None:
    controller = controller_of(name)
    found = list(reserves(controller))
    assert [each.loop for each in found] == list(controller.loops)
    for each in found:
        highest_c = controller.loops[each.loop].setpoint.maximum_c
        assert settled_c(controller, each.loop, each.needed_w) == pytest.approx(highest_c, abs=0.01)
        warned = [one for one in small_reserves(controller) if one.path[1] == each.heater]
        assert bool(warned) == (each.power_w < 1.3 * each.needed_w)
        assert each.recommended_w == tuple(each.needed_w * (1 + share) for share in RECOMMENDED)


def test_full_duty_is_what_the_algorithm_may_ask_for() -> None:
    limited = changed("oven", ("derivative_filter: 3 s\n    ", f"derivative_filter: 3 s{LESS}    "))
    (reserve,) = reserves(controller_of(limited))
    assert reserve.power_w == pytest.approx(192.0)
    (warned,) = small_reserves(controller_of(limited))
    assert "the reserve is 5 %" in warned.reason
    assert warned.remedy.startswith("Let the heater have 237 to 274 W")


def test_nothing_to_heat_has_no_reserve() -> None:
    controller = controller_of("incubator")
    assert controller.simulation is not None
    warm = controller.simulation.model_copy(update={"ambient_c": 45.0})
    assert list(reserves(controller.model_copy(update={"simulation": warm}))) == []


def test_size_and_check_tell_it(heatwright: Heatwright) -> None:
    text = heatwright("size chamber.yaml").out
    assert text.splitlines()[2].split() == ["what", "value", "unit"]
    for expected in ("45       %", "215 .. 248       W", "0.0226     K/W", "2.4       Ω"):
        assert expected in text
    air = heatwright("size chamber.yaml --json").json["loops"]["air"]
    assert air["walls_W"] == pytest.approx(air["walls"][0]["loss_w"])
    assert air["plant"]["needed_W"] == pytest.approx(air["walls_W"], abs=0.5)
    assert air["wire"]["measured_c"] == 127.0
    oven = heatwright("size oven.yaml --json").json["loops"]["air"]
    assert (oven["walls"], oven["walls_W"], oven["wire"]) == ([], None, None)
    told = heatwright("check --quick chamber.yaml").out
    assert "  air: 240 W, a reserve of 45 % over the 165 W that 70 °C takes" in told
    listed = heatwright("check --quick chamber.yaml --json").json["reserves"]
    assert listed == [{"file": "chamber.yaml", **air["plant"]}]
    weak = changed("oven", ("derivative_filter: 3 s\n    ", f"derivative_filter: 3 s{LESS}    "))
    Path("weak.yaml").write_text(weak, encoding="utf-8")
    for command in ("check --quick", "size"):
        warned = heatwright(f"{command} weak.yaml").out
        assert "outputs.heater.power: the reserve is 5 %" in warned
        assert heatwright(f"{command} chamber.yaml").out.count("Warning") == 0
    (warning,) = heatwright("size weak.yaml --json").json["warnings"]
    assert warning in heatwright("check --quick weak.yaml --json").json["warnings"]
    whole = Path("chamber.yaml").read_text(encoding="utf-8")
    bare = whole[: whole.index("simulation:")]
    Path("bare.yaml").write_text(bare, encoding="utf-8")
    assert "Add a section simulation" in heatwright("size bare.yaml", status=2).err
    assert "reserve" not in heatwright("check --quick bare.yaml").out
