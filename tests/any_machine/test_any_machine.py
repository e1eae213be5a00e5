"""Machines as their owners describe them, and drawn ones: what `check` calls good verifies."""

import pytest
from any_machine.drawing import MACHINES, machine
from rig.firmware import controller_of, edited, whole
from rig.verified import Verdict, rehearsed, verified
from suite import SEED, SIZE, amount

from heatwright.sim.faults import catalogue, try_fault
from heatwright.spec import SpecError, load_text


def expected(text: str) -> list[str]:
    return [line.removeprefix("#> ") for line in text.splitlines() if line.startswith("#> ")]


@pytest.mark.parametrize("name", MACHINES)
def test_it_is_good_or_told_why_not(name: str) -> None:
    text = MACHINES[name]
    try:
        said = [f"{each.reason}. {each.remedy}" for each in rehearsed(load_text(text, name))]
    except SpecError as error:
        said = str(error).replace(f"{name}:", "").splitlines()
    assert said == expected(text)


@pytest.mark.parametrize("name", [name for name, text in MACHINES.items() if not expected(text)])
def test_it_verifies(name: str) -> None:
    found = verified(load_text(MACHINES[name], name), amount("machine_faults"))
    assert found == Verdict(True, found.tried)
    assert found.tried


def test_a_host_closes_the_safety_relay_before_a_switch_is_shorted() -> None:
    """Behind an open relay a shorted switch would heat nothing."""
    text = MACHINES["gluepot"]
    faults = {each.id: each for each in catalogue(controller_of(text), whole(text))}
    result = try_fault(faults["switch_shorted_when_hot"])
    assert (result.detail, result.rule) == ("", "monitor_limit")


@pytest.mark.parametrize("number", range(amount("drawn_verified")))
def test_drawn_ones_verify(number: int) -> None:
    """`make drawn` verifies more of them."""
    spec = machine(number).spec
    found = verified(spec, amount("machine_faults"))
    assert found.red == (), f"SUITE_SEED={SEED} SUITE_SIZE={SIZE} make drawn ARGS='--only {number}'"


def test_a_lock_out_comes_after_the_trips_that_the_machine_withstands() -> None:
    """Those that are derived, and no more; a rule that takes hours is counted for longer."""
    good = {name: text for name, text in MACHINES.items() if not expected(text)}
    found = {name: load_text(text, name).controller.lockout for name, text in good.items()}
    fewer = {name: each.trips for name, each in found.items() if each and "trips" in each.derived}
    assert fewer == {
        "hatcher": 1, "tea_kettle": 2, "temperer": 2, "furnace": 2, "annealer": 1, "powder_oven": 2,
    }  # fmt: skip
    for name, trips in fewer.items():
        more = edited(good[name], f"safety.lockout.trips: {trips + 1}")
        with pytest.raises(SpecError, match=rf"lockout\.trips: .* Use at most {trips};"):
            load_text(more, name)
    slow = "{loops.milk.protection.heating.within: 1200 s, loops.milk.protection.frozen: 'off'}"
    lockout = load_text(edited(good["yoghurt"], slow), "yoghurt").controller.lockout
    assert lockout
    assert lockout.within_s == 3600
