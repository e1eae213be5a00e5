"""The thread that runs the board: it executes commands, keeps the speed, publishes the state."""

import heapq
import math
from collections.abc import Callable, Mapping
from itertools import count
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Event as Flag
from threading import Thread
from time import monotonic
from typing import Any

from heatwright.cli.bench.orders import AT_ONCE, ORDERS
from heatwright.cli.bench.parts import seats_of
from heatwright.cli.bench.parts.seat import BadOrder, Order
from heatwright.cli.bench.recorded import Recorded, in_words
from heatwright.cli.bench.store import Store
from heatwright.cli.bench.view import View
from heatwright.cli.bench.world import LiveWorld
from heatwright.sim.binary.elf import Elf
from heatwright.sim.live import Clock
from heatwright.spec import Controller

SLICE_S = 0.02
"""Real time between two checks for commands, s: the longest time for which a key press waits."""
TELL_S = 0.02
TELL_QUICK_S = 0.1
"""Shortest real time between two updates of the tabs, s: up to real time, and at higher speeds."""
PICTURE_S, PICTURE_QUICK_S = 0.2, 1.0
VARIABLES_S = 0.5
"""Shortest real time, s, between two pictures of a touch display (at speeds up to real time, and
above), and between two readings of all variables."""
FULL_S = 0.05
"""Approximate real time of a stretch at full speed, s."""
MOST_STRETCH = 20_000
"""Maximum number of steps of time in a stretch."""
FULL = math.inf
ROUNDING_S = 1e-6
"""Longer than a cycle of the processor, s: the end of a step is rounded to whole cycles."""

Answer = Callable[[str], None]
"""Function that gets the error message about a command, or "" if there was no error."""


class Board:
    """The board and its machine, run by a thread of its own.

    store -- the data for the tabs; world -- the simulated machine, used only by that thread; speed
    -- board time divided by real time: FULL for as fast as possible, 0 while paused; failed -- the
    error that has ended the thread; when_failed -- called after that.
    """

    page = "index.html"

    def __init__(
        self, controller: Controller, program: Path | Elf, name: str, *, speed: float = 1.0
    ) -> None:
        """Power the board on; name -- the spec's file name."""
        self.name, self.controller = name, controller
        self.world = LiveWorld(controller, program)
        self.seats = seats_of(controller)
        self.view = View(self.world, self.seats)
        self.store = Store(self.view.about(name))
        self.recorded = Recorded()
        self.failed: BaseException | None = None
        self.when_failed: Callable[[], None] = lambda: None
        self.speed = speed
        self._orders: SimpleQueue[tuple[Order, Answer]] = SimpleQueue()
        self._waiting: tuple[Order, Answer] | None = None
        self._due: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = count()
        self._stop = Flag()
        self._per_s = 1000.0
        self._told_s = self._pictured_s = self._read_s = -math.inf
        self._rated = (monotonic(), self.world.now_s)
        self._rate = 0.0
        self.set_speed(speed)
        self._thread = Thread(target=self._run, name="board", daemon=True)

    # -- called by the server ------------------------------------------------------------------

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._stop.set()
        self._thread.join()

    def order(self, order: Order, answer: Answer) -> None:
        """Queue a command; answer -- called in the board's thread, with the error message or ""."""
        self._orders.put((order, answer))

    def scenario(self) -> str:
        """Return the recorded actions as a scenario file. Raises Unsaid: there are too many."""
        return self.recorded.text(self.name, self.world.now_s)

    # -- called by commands --------------------------------------------------------------------

    def set_speed(self, speed: float) -> None:
        """Change the speed: board time divided by real time; 0 pauses the board."""
        self.speed = speed
        self._begins_s = self.world.now_s
        self._clock = Clock(speed if 0 < speed < FULL else 1.0)

    @property
    def is_quick(self) -> bool:
        """Whether the board runs faster than real time, or is paused."""
        return self.speed > 1 or self.speed == 0

    def later(self, in_s: float, act: Callable[[], None]) -> None:
        """Schedule an action in `in_s` seconds of board time."""
        heapq.heappush(self._due, (self.world.now_s + in_s, next(self._numbers), act))

    def record(self, event: Mapping[str, Any]) -> None:
        """Record an event for a scenario; key at_s -- its time, if not now."""
        what = dict(event)
        at_s = what.pop("at_s", self.world.now_s)
        self.recorded.event(at_s, what)
        self.view.journal(at_s, in_words(what))

    def remark(self, text: str) -> None:
        """Record as a comment what a scenario cannot express."""
        self.recorded.remark(self.world.now_s, text)
        self.view.journal(self.world.now_s, text)

    def step(self) -> None:
        """Advance by one period of the fastest loop, while paused."""
        self.go_to(self.world.now_s + self.controller.shortest_period_s)

    # -- the thread ----------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                self._take_orders()
                if self.speed == 0:
                    self.tell(force=True)
                    self._await_order()
                elif self.speed == FULL:
                    self._go_at_full_speed()
                else:
                    self._go_at_pace()
                self.tell()
        except BaseException as error:
            self.failed = error  # the command raises it once the server has ended
            self.when_failed()

    def _await_order(self) -> None:
        try:
            self._waiting = self._orders.get(timeout=0.1)
        except Empty:
            self._waiting = None

    def _take_orders(self, *, at_once: bool = False) -> None:
        """Execute commands; at_once -- only those that are allowed within a step of the machine."""
        while self._next_order():
            assert self._waiting is not None  # noqa: S101 - _next_order has set it
            order, answer = self._waiting
            if at_once and order.get("do") not in AT_ONCE:
                return
            self._waiting = None
            answer(self.do(order))

    def _next_order(self) -> bool:
        if self._waiting is None:
            try:
                self._waiting = self._orders.get_nowait()
            except Empty:
                return False
        return True

    def do(self, order: Order) -> str:
        """Execute a command, in the board's thread; return an error message, or ""."""
        act = ORDERS.get(str(order.get("do")))
        if act is None:
            return f"There is no command {order.get('do')!r}."
        try:
            act(self, order)
        except BadOrder as error:
            return str(error)
        except (LookupError, ValueError) as error:
            return f"This cannot be done now: {error}"
        return ""

    # -- time ----------------------------------------------------------------------------------

    def _go_at_pace(self) -> None:
        """Advance by the board time of one SLICE_S, but at least by one step of the machine."""
        world = self.world
        steps = int(self.speed * SLICE_S / world.step_s)
        if steps > 1:
            self.go_to(world.now_s + steps * world.step_s)
            self._clock.wait(world.now_s - self._begins_s)
        else:
            world.act_within(self._run_in_slices)

    def _go_at_full_speed(self) -> None:
        """Advance as far as possible in about FULL_S of real time."""
        begin_s, from_s = monotonic(), self.world.now_s
        steps = max(1, min(MOST_STRETCH, round(self._per_s * FULL_S)))
        self.go_to(from_s + steps * self.world.step_s)
        took_s = max(monotonic() - begin_s, 1e-6)
        done = (self.world.now_s - from_s) / self.world.step_s
        self._per_s += 0.5 * (done / took_s - self._per_s)

    def go_to(self, time_s: float) -> None:
        """Advance to a time, in whole steps, and execute all actions that are due before it."""
        world = self.world
        while (left := round((time_s - world.now_s) / world.step_s)) > 0:
            undisturbed = left
            if self._due:
                undisturbed = min(left, math.floor((self._due[0][0] - world.now_s) / world.step_s))
            if undisturbed > 0:
                world.run(undisturbed * world.step_s)
            else:
                world.act_within(self._run_and_act)

    def _run_and_act(self, end_s: float) -> None:
        """Run the device to the end of a step, and execute the actions that are due before it."""
        while self._due and self._due[0][0] <= end_s:
            at_s, _, act = heapq.heappop(self._due)
            self.world.device.advance(max(at_s, self.world.now_s))
            act()
        self.world.device.advance(end_s)

    def _run_in_slices(self, end_s: float) -> None:
        """Run the device to the end of a step in slices of real time, with commands between."""
        device = self.world.device
        while (left_s := end_s - device.time_s) > ROUNDING_S:
            if self._waiting is None and not self._stop.is_set():
                self._take_orders(at_once=True)
            hurries = self._waiting is not None or not 0 < self.speed < FULL
            part_s = left_s if hurries else min(left_s, self.speed * SLICE_S)
            self._run_and_act(device.time_s + part_s if part_s < left_s else end_s)
            if not hurries:
                self.tell()
                self._clock.wait(device.time_s - self._begins_s)

    # -- data for the tabs ---------------------------------------------------------------------

    def tell(self, *, force: bool = False) -> None:
        """Publish the new state to the tabs, if an update is due."""
        now_s = monotonic()
        if now_s - self._told_s < (TELL_QUICK_S if self.speed > 1 else TELL_S) and not force:
            return
        self._told_s = now_s
        self.world.device.feed()
        picture_s = PICTURE_QUICK_S if self.speed > 1 else PICTURE_S
        if self.store.watchers and now_s - self._pictured_s >= picture_s:
            self._pictured_s = now_s
            self.view.draw(self.store)
        variables = None
        if now_s - self._read_s >= VARIABLES_S:
            self._read_s = now_s
            variables = self.view.variables()
        state = self.view.state()
        state["speed"] = "full" if self.speed == FULL else self.speed
        state["rate"] = self._rate_now(now_s)
        state["pictures"] = dict(self.store.drawn)
        self.store.publish(state, self.view.points(), self.view.lines(), variables)

    def _rate_now(self, now_s: float) -> float:
        """Return board time divided by real time, over the last second or so."""
        since_s, from_s = self._rated
        if now_s - since_s >= 1.0:
            self._rate = round((self.world.now_s - from_s) / (now_s - since_s), 2)
            self._rated = now_s, self.world.now_s
        return self._rate
