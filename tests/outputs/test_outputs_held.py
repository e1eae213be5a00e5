"""Minimum times and the interlock, tick by tick against the reference, at the pins."""

import pytest
from held_course import (
    BOTH,
    COOL,
    HEAT,
    KINDS,
    NONE,
    PINS,
    VARIANTS,
    HeldBoard,
    Orders,
    any_orders_problem,
    held,
    timed_problem,
    windows_problem,
)


@pytest.mark.parametrize("board", PINS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_any_orders(board: str, variant: str) -> None:
    assert any_orders_problem(held(*VARIANTS[variant], board=board)) == ""


def on_for(bench: HeldBoard, orders: Orders, most: int = 1000) -> tuple[int, int]:
    """Tick with the same orders until something changes; return the ticks and what is on then."""
    before = bench.seen()
    for number in range(1, most):
        (heater, cooler), _ = bench.tick(orders)
        if (heater, cooler) != before:
            return number, heater + 2 * cooler
    return most, before[0] + 2 * before[1]


@pytest.mark.parametrize(
    ("heater", "cooler", "course"),
    [
        # 200 ms from the start of the clock are the twentieth tick, and it is asked for in the
        # first; without a minimum the first tick comes before the order.
        (", minimum_off: 200 ms", "", [(HEAT, (20, 1))]),
        (", minimum_on: 300 ms", "", [(HEAT, (2, 1)), (NONE, (30, 0))]),
        # A fault waits for no minimum, and the pause counts from there.
        (
            ", minimum_on: 1 s, minimum_off: 200 ms",
            "",
            [(HEAT, (20, 1)), (HEAT._replace(latched=True), (1, 0)), (HEAT, (20, 1))],
        ),
        # A stop does not even wait for a tick's interrupt.
        (", minimum_on: 1 s", "", [(HEAT, (2, 1)), (HEAT._replace(stop=True), (1, 0))]),
        # One waits for the other's minimum.
        ("", ", minimum_on: 500 ms", [(COOL, (2, 2)), (HEAT, (50, 0)), (HEAT, (1, 1))]),
        # Asked for both, it is the first one.
        ("", "", [(BOTH, (2, 1)), (BOTH, (1000, 1))]),
    ],
)
def test_after_how_many_ticks_what_is_on(
    heater: str, cooler: str, course: list[tuple[Orders, tuple[int, int]]]
) -> None:
    bench = HeldBoard(held(heater, cooler))
    assert [on_for(bench, orders) for orders, _ in course] == [due for _, due in course]
    assert bench.overlap() == 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("percent", [1, 37, 99, 100])
def test_no_other_heater_overlaps_with_the_cooler(kind: str, percent: int) -> None:
    place = held(cooler=", minimum_on: 30 ms", kind=kind)
    assert timed_problem(place, percent=percent) == ""


def test_windows_beside_a_cooler() -> None:
    assert windows_problem(held(kind="windows")) == ""
