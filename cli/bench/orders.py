"""The commands that a tab may send, by name; anything else is refused."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING

from heatwright.cli.bench.parts.seat import BadOrder, Order, flag_of, number_of, text_of
from heatwright.cli.bench.recorded import said
from heatwright.cli.bench.world import LEAST_SUPPLY, MOST_SUPPLY
from heatwright.sim.scenario import actions

if TYPE_CHECKING:
    from heatwright.cli.bench.board import Board

Act = Callable[["Board", Order], None]
SLOWEST, FASTEST = 0.1, 1000.0
"""Speeds, as board time divided by real time."""
COLDEST_C, HOTTEST_C = -40.0, 80.0
"""Range of the ambient temperature."""
MOST_FEED_MM_PER_S = 50.0


def _speed(board: Board, order: Order) -> None:
    if order.get("speed") == "full":
        board.set_speed(math.inf)
    elif order.get("speed") == 0:
        board.set_speed(0.0)
    else:
        board.set_speed(number_of(order, "speed", SLOWEST, FASTEST))


def _step(board: Board, order: Order) -> None:
    del order
    board.set_speed(0.0)
    board.step()


def _at(board: Board, order: Order) -> None:
    """Pass a command to an interface."""
    number = order.get("interface")
    if isinstance(number, bool) or not isinstance(number, int):
        raise BadOrder("interface: the number of an interface is needed.")
    if not 0 <= number < len(board.seats):
        raise BadOrder(f"There is no interface {number}.")
    board.seats[number].act(board, order)


def _fault(board: Board, order: Order) -> None:
    name, on = text_of(order, "fault", 120), flag_of(order, "on")
    board.world.breakage.bring(name) if on else board.world.breakage.mend(name)
    board.remark(f"fault {name} {'on' if on else 'off'}")


def _ambient(board: Board, order: Order) -> None:
    ambient_c = number_of(order, "ambient_c", COLDEST_C, HOTTEST_C)
    board.world.set_ambient(ambient_c)
    board.remark(f"surroundings of {ambient_c:g} °C")


def _supply(board: Board, order: Order) -> None:
    percent = number_of(order, "percent", 100 * LEAST_SUPPLY, 100 * MOST_SUPPLY)
    board.world.wiring.volts = percent / 100
    board.remark(f"the heaters' supply has {percent:g} % of its voltage")


def _load(board: Board, order: Order) -> None:
    heater = text_of(order, "heater", 80)
    powers_w = dict(board.world.heaters_w)
    if heater not in powers_w:
        raise BadOrder(f"The machine has no heater {heater}.")
    watts = number_of(order, "watts", 0.0, powers_w[heater])
    board.world.take_heat(heater, watts)
    board.remark(f"{watts:g} W are taken away at {heater}")


def _feed(board: Board, order: Order) -> None:
    speed = number_of(order, "mm_per_s", 0.0, MOST_FEED_MM_PER_S)
    board.world.coupling.extruded_mm_per_s = speed
    board.record({"extrude": f"{speed:g} mm/s"})


def _play(board: Board, order: Order) -> None:
    """Play the spec's scenario from now on."""
    del order
    scenario = board.controller.simulated.scenario
    now_s = board.world.now_s
    for event in scenario:
        if event.for_s is None:
            board.recorded.event(now_s + (event.at_s or 0.0), said(event))
    for action in actions(scenario):
        board.later(action.time_s, partial(board.world.do, action))
    board.view.journal(now_s, "The scenario of the spec is played.")


ORDERS: Mapping[str, Act] = {
    "speed": _speed,
    "step": _step,
    "at": _at,
    "fault": _fault,
    "ambient": _ambient,
    "supply": _supply,
    "load": _load,
    "feed": _feed,
    "play": _play,
}
AT_ONCE = ("at", "speed")
"""Commands that can be executed in the middle of a step of the machine."""
