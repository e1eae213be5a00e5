"""Minimum times and the interlock, tick by tick against the reference, at the pins."""

import pytest
from held_firmware import BOARDS, KINDS, Broken, HeldBoard, Orders, course, problem

HEAT = Orders(heater=True, cooler=False)
COOL = Orders(heater=False, cooler=True)
NONE = Orders(heater=False, cooler=False)
BOTH = Orders(heater=True, cooler=True)

VARIANTS = {
    "none": ("", ""),
    "on": (", minimum_on: 150 ms", ""),
    "off": (", minimum_off: 120 ms", ""),
    "both": (", minimum_on: 70 ms, minimum_off: 90 ms", ""),
    "cooler": ("", ", minimum_on: 110 ms, minimum_off: 50 ms"),
    "all": (", minimum_on: 60 ms, minimum_off: 40 ms", ", minimum_on: 80 ms, minimum_off: 70 ms"),
    "low": (", active: low, minimum_on: 60 ms", ", active: low, minimum_off: 40 ms"),
}


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_any_orders(board: str, variant: str) -> None:
    bench = HeldBoard(board, *VARIANTS[variant])
    for seed in range(3):
        assert not problem(bench, course(seed, 400))


def on_for(bench: HeldBoard, orders: Orders, most: int = 1000) -> tuple[int, int]:
    """Tick with the same orders until something changes; return the ticks and what is on then."""
    before = bench.seen()
    for number in range(1, most):
        (heater, cooler), _ = bench.tick(orders)
        if (heater, cooler) != before:
            return number, heater + 2 * cooler
    return most, before[0] + 2 * before[1]


def test_they_are_off_first_for_the_minimum() -> None:
    """200 ms from the start of the clock: the twentieth tick; and it is asked for in the first."""
    bench = HeldBoard("uno", ", minimum_off: 200 ms")
    assert on_for(bench, HEAT) == (20, 1)


def test_once_on_it_stays_on() -> None:
    bench = HeldBoard("uno", ", minimum_on: 300 ms")
    assert on_for(bench, HEAT) == (2, 1)  # the first tick comes before the order
    assert on_for(bench, NONE) == (30, 0)


def test_a_fault_waits_for_no_minimum_and_the_pause_counts_from_there() -> None:
    bench = HeldBoard("uno", ", minimum_on: 1 s, minimum_off: 200 ms")
    assert on_for(bench, HEAT)[1] == 1
    assert on_for(bench, HEAT._replace(latched=True)) == (2, 0)
    assert on_for(bench, HEAT) == (20, 1)


def test_a_stop_waits_for_no_tick() -> None:
    bench = HeldBoard("uno", ", minimum_on: 1 s")
    assert on_for(bench, HEAT)[1] == 1
    assert on_for(bench, HEAT._replace(stop=True)) == (1, 0)


def test_the_other_waits_for_a_minimum() -> None:
    bench = HeldBoard("uno", "", ", minimum_on: 500 ms")
    assert on_for(bench, COOL)[1] == 2
    assert on_for(bench, HEAT) == (50, 0)
    assert on_for(bench, HEAT) == (1, 1)
    assert bench.overlap() == 0


def test_asked_for_both_it_is_the_first_one() -> None:
    bench = HeldBoard("uno")
    assert on_for(bench, BOTH) == (2, 1)
    for _ in range(100):
        assert bench.tick(BOTH)[0] == (True, False)
    assert bench.overlap() == 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("percent", [1, 37, 99, 100])
def test_no_other_heater_overlaps_with_the_cooler(kind: str, percent: int) -> None:
    bench = HeldBoard("uno", kind, ", minimum_on: 30 ms")
    bench.percent = percent
    for each in course(percent, 600):
        bench.switches["heater"].on_fraction()
        _, due = bench.tick(each)
        if kind == "windows":  # in a pause it is off, and the cooler may be on
            bench.models["heater"].on = bench.told()[0]
            bench.models["cooler"].on = bench.told()[1]
            assert bench.told() == bench.seen()
        else:
            assert bench.told() == due
    assert not bench.overlap()


def faults(broken: Broken, variant: str) -> str:
    """Say what is wrong with a firmware of which a line is broken."""
    for first in (HEAT, COOL):
        if found := problem(HeldBoard("uno", *VARIANTS[variant], broken), [first] * 30):
            return found
    bench = HeldBoard("uno", *VARIANTS[variant], broken)
    return "".join(problem(bench, course(seed, 300)) for seed in range(3))


HEATER, COOLER = "output_heater.c", "output_cooler.c"
BROKEN = [
    Broken(file, *change)
    for file, name in ((HEATER, "heater"), (COOLER, "cooler"))
    for change in (
        ("wanted = duty_percent > 0.0f;", ""),
        ("duty_percent > 0.0f", "duty_percent > 100.0f"),
        (f"pin_output_{name}_on();", ""),
        (f"pin_output_{name}_off();", ""),
        ("if (next != on) {", "if (true) {"),
        ("on = next;", ""),
        (f"next ? OUTPUT_{name.upper()}_MINIMUM_ON_TICKS : OUTPUT_{name.upper()}_MINIMUM_OFF_TICKS",
         f"OUTPUT_{name.upper()}_MINIMUM_ON_TICKS"),
        (f"next ? OUTPUT_{name.upper()}_MINIMUM_ON_TICKS : OUTPUT_{name.upper()}_MINIMUM_OFF_TICKS",
         f"OUTPUT_{name.upper()}_MINIMUM_OFF_TICKS"),
        ("ticks_to_stay--;", ""),
        ("ticks_to_stay--;\n    }", "ticks_to_stay--;\n    }\n    if (ticks_to_stay == 1) {\n"
         "        ticks_to_stay = 0;\n    }"),
        ("ticks_to_stay != 0 ? on : wanted", "wanted"),
        ("switch_to(permitted && next)", "switch_to(next)"),
        ("ticks_to_stay != 0 ? on : wanted", "ticks_to_stay != 0 ? (permitted && on) : false"),
        (f"ticks_to_stay = OUTPUT_{name.upper()}_MINIMUM_OFF_TICKS;", "ticks_to_stay = 0;"),
        ("return on;", "return wanted;"),
    )
] + [
    Broken(HEATER, "wanted = false;", ""),
    Broken(HEATER, "switch_to(false);", ""),
    Broken("gate.c", " && !output_cooler_is_on()", ""),
    Broken("gate.c", "output_cooler_tick(!output_heater_is_on());", "output_cooler_tick(true);"),
]  # fmt: skip


@pytest.mark.parametrize("broken", BROKEN, ids=lambda each: f"{each.file}: {each.right[:40]}")
def test_a_broken_line_is_seen(broken: Broken) -> None:
    assert faults(broken, "all")


PLAIN = [
    Broken(file, right, wrong)
    for file in (HEATER, COOLER)
    for right, wrong in (
        ("permitted && wanted", "wanted"),
        ("permitted && wanted", "permitted"),
        ("on = permitted", "bool on = permitted"),
        ("duty_percent > 0.0f", "duty_percent >= 0.0f"),
    )
]


@pytest.mark.parametrize("broken", PLAIN, ids=lambda each: f"{each.file}: {each.wrong}")
def test_a_broken_line_without_minimum_times_is_seen(broken: Broken) -> None:
    assert faults(broken, "none")


TIMED = [
    Broken(HEATER, "on = counts != 0;", ""),
    Broken(HEATER, "on = counts != 0;", "on = permitted;"),
    Broken(HEATER, "permitted ? output_heater.on_counts : 0", "output_heater.on_counts"),
]


@pytest.mark.parametrize("kind", ["pwm", "pwm by interrupts"])
@pytest.mark.parametrize("broken", TIMED, ids=lambda each: each.wrong)
def test_a_broken_line_of_a_pwm_is_seen(kind: str, broken: Broken) -> None:
    bench = HeldBoard("uno", kind, broken=broken)
    assert any(bench.tick(each)[1] != bench.told() for each in course(1, 400))


WINDOWS = [
    Broken(HEATER, "on = permitted && window_tick < on_ticks;", wrong)
    for wrong in (
        "on = window_tick < on_ticks;",
        "on = permitted;",
        "on = permitted && window_tick <= on_ticks;",
        "",
    )
] + [Broken(HEATER, "return on;", "return on_ticks != 0;")]


@pytest.mark.parametrize("broken", WINDOWS, ids=lambda each: each.wrong)
def test_a_broken_line_of_windows_is_seen(broken: Broken) -> None:
    assert windows_problem(None) == ""
    assert windows_problem(broken)


def windows_problem(broken: Broken | None) -> str:
    """Say what is wrong with a heater in windows of a second; empty if nothing."""
    bench = HeldBoard("uno", "windows", broken=broken)
    bench.percent = 37
    on = 0
    for number in range(101):  # orders come after the first tick
        (heater, _), _ = bench.tick(HEAT)
        on += heater
        if bench.told()[0] != heater:
            return f"tick {number}: it is not {bench.told()[0]}"
    if on != bench.percent:
        return f"on for {on} ticks"
    for orders in (HEAT._replace(latched=True), COOL, BOTH):
        bench.tick(orders)  # the orders come after this tick's interrupt
        seen = [bench.tick(orders)[0] for _ in range(110)]
        if orders.latched and any(heater for heater, _ in seen):
            return "on with a fault latched"
    return "both on at once" if bench.overlap() else ""
