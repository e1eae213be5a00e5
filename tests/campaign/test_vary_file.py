"""What a campaign varies: its file, its draws, and what is refused."""

import re
from pathlib import Path

import numpy as np
import pytest
from rig.commands import Heatwright
from rig.firmware import EXAMPLE_NAMES, EXAMPLES, ROOT, example

from heatwright.cli.campaign.given import derived, given
from heatwright.sim.campaign.breaks import BREAKS
from heatwright.sim.campaign.drawn import draw
from heatwright.sim.campaign.vary import SIGMAS, Spread, Vary, vary_of
from heatwright.sim.plants import powers_of
from heatwright.spec import full_a

REFUSED = """\
capacities: {airr: ± 20 %}  #capacities.airr: there is no airr in the spec. Did you mean air?
capacities: {all: ± 100 %}  #capacities.all: ± 100 % goes down to 0 J/K. Let it stay at 0.001 J/K or above.
capacities: {air: ± 5 K}  #capacities.air: '5 K' does not have the unit of a heat capacity. Use J/K or kJ/K, as in 900 J/K.
capacities: {air: 5 J/K .. 3 J/K}  #capacities.air: '5 J/K .. 3 J/K' ends below its start. Write the lower end first.
capacities: {air: []}  #capacities.air: there is nothing to choose from. Write [900 J/K, …].
resistances: {air-wall: ± 5 %}  #resistances.air-wall: there is no air-wall in the spec. Did you mean air-walls?
ambient: ± 5 %  #ambient: '5 %' does not have the unit of a temperature difference. Use K, as in 2 K.
supply: ± 100 %  #supply: ± 100 % goes down to 0 %. Let it stay at 1 % or above.
errors: {air: ± 2 %}  #errors.air: ± 2 % is a share, and an error of a temperature has the unit K. Write it in K, such as ± 0.5 K.
noise: {air: ± 0.1 K}  #noise.air: ± 0.1 K goes down to -0.1 K. Let it stay at 0 K or above.
late: ± 5 s  #late: ± 5 s is relative, but the spec has no value for it. Write both ends, such as 1 s .. 1 s.
asks: [{loop: sky, at: 1 s, setpoint: 30 °C}]  #asks[0].loop: there is no loop sky in the spec. Use air.
asks: [{loop: air, at: 1 h, setpoint: 30 °C}]  #asks[0].at: 1 h is not before the end of the scenario, at 30 min. Make it earlier.
asks: [{loop: air, at: 1 s, setpoint: 80 °C}]  #asks[0].setpoint: 80 °C exceeds the loop's range of setpoints, 10 °C .. 70 °C. Stay within 10 °C .. 70 °C.
upsets: [{at: 1 s, node: air}]  #upsets[0]: `node` and `by` belong together. Write {at: …, node: …, by: …}.
upsets: [{at: 1 s}]  #upsets[0]: an upset is either a jump of a node or a power cut. Write {at: …, node: …, by: …} or {at: …, power_cut: …}.
upsets: [{at: 1 s, node: sky, by: 1 K}]  #upsets[0].node: there is no node sky in the plant. Use element, air or walls.
upsets: [{at: 1 h, power_cut: 1 s}]  #upsets[0].at: 1 h is not before the end of the scenario, at 30 min. Make it earlier.
faults: {chance: 120 %}  #faults.chance: 120 % is too large. Use at most 100 %.
faults: {chance: 20 %, at: 1 h}  #faults.at: 1 h is not before the end of the scenario, at 30 min. Make it earlier.
faults: {chance: 20 %, of: [heater_opn]}  #faults.of[0]: there is no fault heater_opn. Did you mean heater_open?
faults: {chance: 20 %, of: [fan_stalled]}  #faults.of[0]: no loop of the spec has the part that fan_stalled breaks. Delete fan_stalled.
faults: {}  #faults.chance: this key is missing. Add it: share of the runs with a fault.
colour: red  #colour: there is no such key here. Use capacities, resistances, ambient, supply, errors, noise, late, asks, upsets or faults.
"""  # noqa: E501 - whole messages


@pytest.mark.parametrize("line", REFUSED.splitlines())
def test_what_is_wrong_is_told_with_its_place_and_remedy(heatwright: Heatwright, line: str) -> None:
    text, _, expected = line.partition("  #")
    Path("vary.yaml").write_text(text + "\n", encoding="utf-8")
    told = heatwright("campaign chamber.yaml --vary vary.yaml", status=2).err
    place, _, rest = told.rstrip("\n").partition(": ")
    assert place.startswith("vary.yaml:1:")
    assert rest == expected
    found = heatwright("campaign chamber.yaml --vary vary.yaml --json", status=2).json
    assert [each["path"] for each in found["problems"]] == [expected.partition(":")[0]]


def test_nothing_to_vary_no_machine_and_a_current_wrong_by_kelvins_are_told(
    heatwright: Heatwright,
) -> None:
    Path("vary.yaml").write_text("\n", encoding="utf-8")
    told = heatwright("campaign chamber.yaml --vary vary.yaml", status=2).err
    assert told.startswith("vary.yaml:1:1: this file is empty. Write what varies, such as ")
    spec = Path("chamber.yaml").read_text("utf-8").partition("simulation:")[0]
    Path("bare.yaml").write_text(spec, encoding="utf-8")
    assert "has no `simulation`" in heatwright("campaign bare.yaml", status=2).err
    assert "none.yaml" in heatwright("campaign chamber.yaml --vary none.yaml", status=2).err
    Path("vary.yaml").write_text("errors: {current: ± 1 K}\n", encoding="utf-8")
    told = heatwright(f"campaign {EXAMPLES}/fabricator.yaml --vary vary.yaml", status=2).err
    assert "and ± 1 K is not a share of it. Write a share, such as ± 2 %." in told


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_what_suits_any_machine_is_written_as_a_file_would_be(name: str, tmp_path: Path) -> None:
    """For every example; each quantity that it names is drawn, within its ends."""
    spec = example(name)
    controller = spec.controller
    vary = given(spec, None)
    assert vary == derived(controller)
    own = controller.simulated.plant
    for run in range(20):
        drawn = draw(controller, vary, 3, run)
        plant = drawn.controller.simulated.plant
        for node, capacity in plant.nodes.items():
            assert 0.8 * own.nodes[node] <= capacity <= 1.2 * own.nodes[node]
            assert capacity != own.nodes[node]
        for link, drawn_link in zip(own.links, plant.links, strict=True):
            share = drawn_link.resistance_k_per_w / link.resistance_k_per_w
            assert 0.8 <= share <= 1.2
        for loop in controller.loops.values():
            error_k = drawn.errors[loop.sensor]
            sensor = controller.thermometers[loop.sensor]
            assert 0 < abs(error_k) <= 1.01 * sensor.error_k(loop.setpoint.maximum_c)
        assert drawn.values["fault"] is None or drawn.values["fault"] in BREAKS


@pytest.mark.parametrize("name", ["chamber", "fabricator", "extruder"])
def test_a_supply_drives_all_loads(name: str) -> None:
    """Heat goes by the square of the voltage, and a current with it."""
    controller = example(name).controller
    drawn = draw(controller, vary_of({"supply": "110 %"}), 0, 0)
    before, after = powers_of(controller), powers_of(drawn.powered)
    for output, power_w in before.items():
        assert after[output] == pytest.approx(1.21 * power_w)
        amperes = full_a(controller.outputs[output]) if hasattr(
            controller.outputs[output], "power_w") else None  # fmt: skip
        if amperes is not None:
            assert full_a(drawn.powered.outputs[output]) == pytest.approx(1.1 * amperes)
    assert drawn.controller.outputs == controller.outputs, "the firmware does not know it"


def test_each_quantity_has_its_own_stream() -> None:
    """What is varied in addition leaves the others as they are, and each run stands alone."""
    controller = example("chamber").controller
    alone = draw(controller, vary_of({"ambient": "± 10 K"}), 5, 7)
    more = draw(controller, vary_of({"ambient": "± 10 K", "capacities": {"all": "± 9 %"}}), 5, 7)
    assert alone.values["ambient_c"] == more.values["ambient_c"]
    assert draw(controller, vary_of({"ambient": "± 10 K"}), 5, 7) == alone
    others = {draw(controller, vary_of({"ambient": "± 10 K"}), seed, run).values["ambient_c"]
              for seed, run in ((5, 8), (6, 7), (7, 5), (0, 0))}  # fmt: skip
    assert len(others | {alone.values["ambient_c"]}) == 5
    assert len({draw(controller, vary_of({}), 0, run).noise_seed for run in range(50)}) == 50


@pytest.mark.parametrize(
    ("spread", "mean", "deviation"),
    [
        (Spread("within", (0.2,), True, ""), 50.0, 10 / 3**0.5),
        (Spread("normal", (3.0,), False, ""), 50.0, 3.0),
        (Spread("between", (10.0, 20.0), False, ""), 15.0, 5 / 3**0.5),
        (Spread("one_of", (1.0, 3.0), False, ""), 2.0, 1.0),
    ],
)
def test_what_is_drawn_spreads_as_it_says(spread: Spread, mean: float, deviation: float) -> None:
    """Within four standard errors of the mean, and of the standard deviation (at most 1/√(2n))."""
    random, count = np.random.default_rng(1), 4000
    found = [spread.draw(random, 50.0) for _ in range(count)]
    low, high = spread.ends(50.0)
    assert low <= min(found)
    assert max(found) <= high
    assert abs(np.mean(found) - mean) < 4 * deviation / count**0.5
    cut = 0.987 if spread.how == "normal" else 1.0  # of a normal one that ends at three sigmas
    assert SIGMAS == 3.0
    assert abs(np.std(found) / deviation - cut) < 4 / (2 * count) ** 0.5


PAGE = (ROOT / "docs" / "campaigns.md").read_text(encoding="utf-8")


def test_the_file_of_the_page_is_taken_and_the_page_has_all_there_is(tmp_path: Path) -> None:
    (text,) = re.findall(r"^```yaml\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    file = tmp_path / "vary.yaml"
    file.write_text(text, encoding="utf-8")
    lines = dict(given(example("chamber"), file).lines())
    assert lines["capacities"] == "all ± 20 %, walls normal 5 %"
    assert lines["ambient"] == "[15 °C, 20 °C, 25 °C]"
    assert lines["asks"] == "air 30 °C .. 60 °C at 10 min .. 12 min, in 50 % of the runs"
    keys = {field.alias or name for name, field in Vary.model_fields.items()}
    assert set(lines) == keys
    assert {*keys, *BREAKS} <= set(re.findall(r"`(\w+)`", PAGE))
