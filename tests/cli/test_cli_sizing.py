"""What a machine's parts have to be, as `size`, `check` and `build` tell it. Walls and wires by
hand and by textbooks; the reserve by the simulated machine itself. What supply and switch of a
heater in pulses have to bear. What the tolerances of parts cost, with a warning of too much, also
in the project's README. And a firmware that does not fit its board: told in the spec's terms, and
what is told is true."""

import math
import pickle
import re
from dataclasses import replace
from pathlib import Path

import pytest
from rig.commands import Heatwright
from rig.commands import changed as written
from rig.firmware import EXAMPLE_NAMES, EXAMPLES, changed, controller_of, example, files_of, whole

from heatwright.cli.firmware import build_firmware
from heatwright.cli.fits import DoesNotFit
from heatwright.cli.loads import loads
from heatwright.cli.loads import told as said_of
from heatwright.cli.talk import _PlainJob
from heatwright.generator.toolchain import TooLarge
from heatwright.generator.toolchain.build import given
from heatwright.sim.plants import FOREVER_S, plant_of, powers_of
from heatwright.spec import Controller, load_text
from heatwright.spec.checks.board.memory import EVERY, Least, least
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


def test_films_are_those_of_the_textbooks() -> None:
    """McAdams' table of wind, which has no step; of a cylinder, Incropera & DeWitt, example 7.4:
    12.7 mm, 128.4 °C in air of 26.2 °C at 10 m/s: 96 W/m²K."""
    assert wind_film(0.0) == pytest.approx(5.62, abs=0.005)
    assert wind_film(1.0) - wind_film(0.0) == pytest.approx(3.91, abs=0.005)
    assert wind_film(4.8767) == pytest.approx(wind_film(4.8769), rel=0.001)
    assert wind_film(10.0) == pytest.approx(7.17 * 10**0.78, rel=0.001)
    film = cross_flow_film_w_per_m2k(0.0127, 10.0, (128.4 + 26.2) / 2)
    assert film == pytest.approx(96, rel=0.01)


@pytest.mark.parametrize("emissivity", [0.0, 0.9])
def test_a_wire_has_its_power_its_load_and_the_temperature_of_both(emissivity: float) -> None:
    found = sized_wire(Wire.model_validate({**WIRE, "emissivity": emissivity}), 240.0, 24.0, 20.0)
    diameter_m = found.diameter_mm / 1000
    ohm = 1.1e-6 * found.length_m / (math.pi * diameter_m**2 / 4)
    assert (ohm, found.current_a) == (pytest.approx(2.4), 10.0)
    surface_m2 = math.pi * diameter_m * found.length_m
    assert 240 / surface_m2 == pytest.approx(2e4)
    film = cross_flow_film_w_per_m2k(diameter_m, 2.0, (found.temperature_c + 20) / 2)
    radiated = emissivity * SIGMA * ((found.temperature_c + 273.15) ** 4 - 293.15**4)
    assert film * (found.temperature_c - 20) + radiated == pytest.approx(2e4)


def test_the_load_that_ends_as_measured_does() -> None:
    load = sized_wire(Wire.model_validate(WIRE), 240.0, 24.0, 20.0).load_as_measured_w_per_cm2
    assert load is not None
    loaded = Wire.model_validate({**WIRE, "surface_load": f"{load!r} W/cm²"})
    assert sized_wire(loaded, 240.0, 24.0, 20.0).temperature_c == pytest.approx(127.0, abs=1e-6)
    assert sized_wire(Wire.model_validate(WIRE), 240.0, 24.0, 130.0)[-1] is None


def settled_c(controller: Controller, loop: str, power_w: float) -> float:
    """The loop's sensor in the simulated machine without its noise, after years at a power."""
    simulation, heater = controller.simulated, controller.loops[loop].heater
    senses = simulation.plant.sense.items()
    still = {name: sense.model_copy(update={"noise_k": 0.0}) for name, sense in senses}
    network = simulation.plant.model_copy(update={"sense": still})
    machine = plant_of(controller, network, ambient_c=simulation.ambient_c, step_s=FOREVER_S)
    fans = dict.fromkeys(always_running(controller.outputs), 1.0)
    running = dict.fromkeys(controller.outputs, 0.0) | fans
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
    assert warned.remedy.startswith("Use a heater of 237 to 274 W")


def test_nothing_to_heat_has_no_reserve() -> None:
    controller = controller_of("incubator")
    warm = controller.simulated.model_copy(update={"ambient_c": 45.0})
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
    assert "  air: 240 W, a reserve of 45 % over the 165 W that 70 °C needs" in told
    listed = heatwright("check --quick chamber.yaml --json").json["reserves"]
    assert listed == [{"file": "chamber.yaml", **air["plant"]}]
    weak = changed("oven", ("derivative_filter: 3 s\n    ", f"derivative_filter: 3 s{LESS}    "))
    Path("weak.yaml").write_text(weak, encoding="utf-8")
    for command in ("check --quick", "size"):
        assert "outputs.heater.power: the reserve is 5 %" in heatwright(f"{command} weak.yaml").out
        assert heatwright(f"{command} chamber.yaml").out.count("Warning") == 0
    (warning,) = heatwright("size weak.yaml --json").json["warnings"]
    assert warning in heatwright("check --quick weak.yaml --json").json["warnings"]
    whole = Path("chamber.yaml").read_text(encoding="utf-8")
    Path("bare.yaml").write_text(whole[: whole.index("simulation:")], encoding="utf-8")
    assert "Add a section simulation" in heatwright("size bare.yaml", status=2).err
    assert "reserve" not in heatwright("check --quick bare.yaml").out


SUPPLY_V, WIRE_OHM, LIMIT_A = 43.0, 8.54, 3.0  # the fabricator's, as published


def test_the_fabricators_wire_draws_five_amperes_and_three_rms() -> None:
    (load,) = loads(controller_of("fabricator"))
    assert load["peak_a"] == pytest.approx(SUPPLY_V / WIRE_OHM, rel=1e-3)
    assert load["rms_a"] == pytest.approx(LIMIT_A, rel=2e-3)
    assert load["full_w"] == pytest.approx(load["rms_a"] ** 2 * WIRE_OHM, rel=1e-3)
    assert load["mean_a"] == pytest.approx(load["full_w"] / SUPPLY_V)
    assert load["dead_w"] == pytest.approx(SUPPLY_V**2 / WIRE_OHM, rel=1e-3)
    told = "heater: supply and switch carry 5.04 A while it is on; at full duty"
    assert said_of(load).startswith(told)


def test_without_a_lower_rating_all_three_are_one() -> None:
    (load,) = loads(controller_of(changed("fabricator", (", rated: 25.57 V", ""))))
    assert load["peak_a"] == load["rms_a"] == load["mean_a"] == pytest.approx(76.6 / SUPPLY_V)
    assert load["dead_w"] == load["full_w"]


def test_check_prints_it(heatwright: Heatwright) -> None:
    """And nothing of what has no such currents."""
    assert not any([*loads(controller_of(name))] for name in ("chamber", "extruder", "kiln"))
    text = (EXAMPLES / "fabricator.yaml").read_text(encoding="utf-8")
    Path("fabricator.yaml").write_text(text, encoding="utf-8")
    (load,) = loads(controller_of("fabricator"))
    assert f"  {said_of(load)}\n" in heatwright("check --quick fabricator.yaml").out
    (listed,) = heatwright("check --quick fabricator.yaml chamber.yaml --json").json["loads"]
    assert listed == {"file": "fabricator.yaml", **load}


FEEDER = (EXAMPLES / "feeder.yaml").read_text(encoding="utf-8")
ASKED = "accuracy: {within: 1 K, between: 180 °C .. 250 °C}"


def warnings(heatwright: Heatwright, text: str) -> list[str]:
    Path("feeder.yaml").write_text(text, encoding="utf-8")
    found = heatwright("check --quick feeder.yaml --json").json
    return [each["reason"] for each in found["warnings"] if each["path"].endswith("accuracy")]


def test_check_warns_of_parts_that_cost_too_much(heatwright: Heatwright) -> None:
    (told,) = warnings(heatwright, FEEDER)
    assert "3.07 K at 250 °C, 1.15 K as root" in told
    assert warnings(heatwright, FEEDER.replace("within: 1 K", "within: 3.1 K")) == []
    (told,) = warnings(heatwright, FEEDER.replace("within: 1 K", "within: 3.06 K"))
    assert "3.06 K is required" in told
    assert warnings(heatwright, FEEDER.replace(ASKED, "")) == []
    text = FEEDER.replace("within: 1 K", "within: 9 K").replace("element: A, ", "")
    (told,) = warnings(heatwright, text)
    assert told == "it is unknown whether the error stays within 9 K"


def test_a_worst_case_without_a_part_is_called_so(heatwright: Heatwright) -> None:
    """By `check`, its warning and the README; whole again as soon as the part is told."""
    for told, name in (("element: A, ", "worst case"), ("", "worst case of the given tolerances")):
        text = FEEDER.replace("element: A, ", told)
        (said,) = warnings(heatwright, text)
        assert said.startswith(f"in the {name} the parts add")
        assert re.search(rf"^ {name}  ", heatwright("check --quick feeder.yaml").out, re.MULTILINE)
        assert f"| {name} |" in files_of(text)["README.md"]


@pytest.mark.parametrize("label", ["element", "R₀", "ADC", "worst case", "root of the squares"])
def test_lines_json_and_readme_have_the_same_numbers(heatwright: Heatwright, label: str) -> None:
    path = EXAMPLES / "feeder.yaml"
    lines = heatwright(f"check --quick {path}").out.splitlines()
    (shown,) = (line.split()[-5:] for line in lines if line.strip().startswith(f"{label} "))
    rows = files_of(FEEDER)["README.md"].splitlines()
    (row,) = (line for line in rows if line.startswith(f"| {label} |"))
    assert [each.strip() for each in row.split("|")[3:-1]] == shown
    budget = heatwright(f"check --quick {path} --json").json["good"][0]["budgets"]["nozzle"]
    listed = {each["part"]: each["errors"] for each in budget["parts"]}
    listed |= {"worst case": budget["worst"], "root of the squares": budget["root_of_squares"]}
    assert [f"{each:.2f}" for each in listed[label]] == shown


def test_a_controller_without_an_adc_has_no_budget(heatwright: Heatwright) -> None:
    assert "errors from its parts" not in heatwright("check --quick chamber.yaml").out
    assert "## Accuracy" not in files_of((EXAMPLES / "chamber.yaml").read_text())["README.md"]


def test_what_is_not_told_has_no_part_in_the_digest() -> None:
    (line,) = (each for each in FEEDER.splitlines() if "tolerances:" in each)
    told, empty, without = (
        load_text(FEEDER.replace(line, other).replace(ASKED, "")).digest
        for other in (line, "    tolerances: {}", "")
    )
    assert told != empty == without
    assert load_text(FEEDER).digest != told


def test_too_many_entries_for_the_ram(heatwright: Heatwright) -> None:
    told = heatwright(f"build {written('kiln_uno', 'entries: 96', 'entries: 166')} --json", 2)
    build, found = told.json["build"], told.json["too_large"]
    assert found["ram"] == build["ram"] + build["stack"] - build["ram_limit"] > found["flash"] == 0
    assert f"of 2,048 B: {found['ram']} B too many" in told.err
    for memory in ("flash", "ram"):
        assert sum(part[memory] for part in found["parts"]) == build[memory]
    assert heatwright("verify changed.yaml --json", 2).json["too_large"] == found
    most = int(found["savings"][0]["change"].removeprefix("at most "))
    for entries, status in ((most, 0), (most + 1, 2)):
        heatwright(f"build {written('kiln_uno', 'entries: 96', f'entries: {entries}')}", status)


def test_the_linkers_refusal_is_measured_and_told_whole_by_another_process() -> None:
    spec = changed(
        "extruder", ("mega2560", "atmega16"), ("A13", "PA0"), ("pin: D10, f", "pin: PD5, f"),
        ("pin: D10, p", "pin: PD5, p"), ("pwm, pin: D9, frequency: 122 Hz", "digital, pin: PB3"),
    )  # fmt: skip
    with pytest.raises(DoesNotFit) as caught:
        build_firmware(load_text(spec), _PlainJob("Building"))
    told = str(pickle.loads(pickle.dumps(caught.value)))  # noqa: S301 - our own
    assert f"of 16,384 B: {caught.value.what.built.flash_bytes - 16384:,} B too many\n" in told
    assert "interfaces[0]: leave it out: 9," in told
    assert "safety.self_checks: false: 7" in told
    assert "ld:" not in told


def test_check_warns_to_the_byte(heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch) -> None:
    spare = 32256 - least(example("chamber").controller).flash
    for over, warned in ((0, []), (1, ["flash: at least 32,257 of 32,256 B: 1 B too many"])):
        taken = Least(EVERY.flash + spare + over, 0)
        monkeypatch.setattr("heatwright.spec.checks.board.memory.EVERY", taken)
        found = heatwright("check --quick chamber.yaml --json").json["warnings"]
        assert [each["reason"] for each in found] == warned


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_a_binary_of_a_byte_too_many_is_refused_and_takes_what_check_counts(name: str) -> None:
    elf, controller = whole(name).path, example(name).controller
    board, bound, built = controller.board, least(controller), given(elf, controller.board)
    assert bound.flash <= built.flash_bytes < 2 * bound.flash
    assert bound.ram <= built.ram_bytes + built.stack_bytes
    for key, free in (("flash_bytes", built.flash_over), ("ram_bytes", built.ram_over)):
        exact = getattr(board, key) + free
        given(elf, replace(board, **{key: exact}))
        with pytest.raises(TooLarge):
            given(elf, replace(board, **{key: exact - 1}))
