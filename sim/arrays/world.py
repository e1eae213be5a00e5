"""N controllers on N machines, each pair in one lane of the arrays: `bench`, side by side."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from heatwright.sim.arrays.masks import AllLanesError, afresh
from heatwright.sim.arrays.modules import on_arrays
from heatwright.sim.arrays.plant import Plants
from heatwright.sim.arrays.stack import UnlikeError, stacked
from heatwright.sim.bench import ReferenceDevice, Run, bench, step_of
from heatwright.sim.plants import plant_of
from heatwright.sim.reference.programs.copies import column_of
from heatwright.sim.scenario import actions, end_s
from heatwright.sim.trace import StepLog, Trace
from heatwright.spec import Controller, Event

Progress = Callable[[float, float], None]
Logs = dict[str, StepLog]
"""Control steps by loop."""


def bench_lanes(
    controllers: Sequence[Controller],
    scenario: Iterable[Event],
    *,
    machines: Sequence[Controller] | None = None,
    seed: int = 0,
) -> list[Trace]:
    """Run reference devices against their machines; each trace is that of `bench` alone.

    controllers -- their numbers may differ, and those of their machines, but no times; scenario --
    the events of all lanes; machines -- the controllers to whose machines they are wired; their own
    if None; seed -- seed of the sensor noise. Raises UnlikeError: the controllers differ in more
    than numbers; AllLanesError: something that all lanes share would change for some of them only;
    ValueError: one has no simulation.
    """
    runs = _Runs(controllers, machines or controllers, tuple(scenario), seed=seed)
    with afresh():
        runs.go(None)
        return runs.traces()


def step_logs(
    controllers: Sequence[Controller],
    scenario: Iterable[Event],
    kept: Iterable[str],
    *,
    machines: Sequence[Controller] | None = None,
    progress: Progress | None = None,
) -> list[Logs]:
    """Return the control steps of each lane of `bench_lanes`, with only these members.

    If lanes cannot run together, they run one by one, with the same values, and all members.
    """
    events, wired = tuple(scenario), machines or controllers
    try:
        runs = _Runs(controllers, wired, events, kept=kept)
        with afresh():
            runs.go(progress)
            return runs.logs()
    except (AllLanesError, UnlikeError):
        return [
            dict(bench(machine, ReferenceDevice(own), events, progress=progress).steps)
            for own, machine in zip(controllers, wired, strict=True)
        ]


def device_of(controllers: Sequence[Controller]) -> Any:
    """Return the reference devices of controllers that differ only in numbers, as one device.

    It has the methods of `ReferenceDevice`; each argument and result may be an array. Raises
    UnlikeError: they differ in more than numbers.
    """
    kind = on_arrays("heatwright.sim.reference.device").ReferenceDevice
    return stacked([kind(each) for each in controllers])


class _LaneDevice:
    """The devices of all lanes; only the requested members of their steps are kept."""

    def __init__(self, controllers: Sequence[Controller], kept: Iterable[str] | None) -> None:
        """Power all devices on; kept -- members of a step to keep, None for all."""
        self._all = device_of(controllers)
        self._lanes = len(controllers)
        self._kept = None if kept is None else {"time_s", *kept}
        self._logs: dict[str, list[tuple[Any, ...]]] = {name: [] for name in self._all._loops}
        self._kinds = {name: self._kind_of(name) for name in self._all._loops}

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of all devices."""
        return getattr(self._all, name)

    def advance(self, until_s: float) -> None:
        """Run to a time, then drop the members of the steps that are not to be kept."""
        self._all.advance(until_s)
        for name, log in self._logs.items():
            rows = self._all._loops[name]._rows
            while len(rows) > 1:  # a fault that comes late may still change the last row
                log.append(self._packed(name, rows.popleft()))

    def logs(self, loop: str) -> list[StepLog]:
        """Return for each lane a log of the loop, with a row for every control step so far."""
        _, kind = self._kinds[loop]
        last = self._all._loops[loop]._rows
        rows = [*self._logs[loop], *(self._packed(loop, row) for row in last)]
        found = np.zeros((self._lanes, len(rows)), kind)
        for place, name in enumerate(kind.names or ()):
            column = found[name]
            for number, row in enumerate(rows):
                if kind[name].names is None:
                    column[:, number] = row[place]
                else:
                    column[:, number] = [_own(row[place], lane) for lane in range(self._lanes)]
        return list(found)

    def _kind_of(self, loop: str) -> tuple[list[int], np.dtype[Any]]:
        modelled = self._all._loops[loop]
        members = [
            ("time_s", "f8"), *modelled.reference.members, *column_of(modelled._points),
        ]  # fmt: skip
        places = [
            place for place, (name, _) in enumerate(members)
            if self._kept is None or name in self._kept
        ]  # fmt: skip
        return places, np.dtype([members[place] for place in places])

    def _packed(self, loop: str, row: tuple[Any, ...]) -> tuple[Any, ...]:
        places, kind = self._kinds[loop]
        return tuple(
            value.astype(kind[number]) if isinstance(value, np.ndarray) else value
            for number, value in enumerate(row[place] for place in places)
        )


def _own(value: Any, lane: int) -> Any:
    """Return one lane's numbers from tuples and lists."""
    if isinstance(value, np.ndarray):
        return value[lane]
    if isinstance(value, tuple):
        return tuple(_own(each, lane) for each in value)
    return [_own(each, lane) for each in value] if isinstance(value, list) else value


class _Runs(Run):
    """Runs in all lanes; without traces of the machines if only some members are kept."""

    def __init__(
        self,
        controllers: Sequence[Controller],
        machines: Sequence[Controller],
        events: Sequence[Event],
        *,
        seed: int = 0,
        kept: Iterable[str] | None = None,
    ) -> None:
        (step_s,) = {step_of(each) for each in machines}
        plants = [
            plant_of(each, own.plant, ambient_c=own.ambient_c, step_s=step_s, seed=seed)
            for each, own in ((each, each.simulated) for each in machines)
        ]
        with afresh():
            self._lanes = _LaneDevice(controllers, kept)
        whole: Any = Plants(plants)
        first = controllers[0]
        super().__init__(first, self._lanes, whole, actions(events), step_s, end_s(events))
        self._coupling = on_arrays("heatwright.sim.coupling").Coupling(first, self._lanes, step_s)
        self._traced = kept is None
        if self._traced:
            rows, lanes = self._count + 1, len(controllers)
            self._temperatures = np.empty((rows, len(whole.nodes), lanes))
            self._sensed = np.empty((rows, len(self._sensors), lanes))
            self._active = np.zeros((rows, len(self._coupling.loads), lanes))
            self._amperes = np.zeros((rows, len(self._meters), lanes))
            self._fed = np.zeros((rows, lanes))

    def _note(self, row: int, felt: Any) -> None:
        if not self._traced:
            return
        values = tuple(felt.values())
        self._temperatures[row] = self._plant.temperatures_c.T
        self._sensed[row] = values[: len(self._sensors)]
        if self._meters:
            self._amperes[row] = values[len(self._sensors) :]

    def _note_outputs(self, row: int, active: Any, fed_mm_per_s: Any) -> None:
        if not self._traced:
            return
        for place, share in enumerate(active.values()):
            self._active[row, place] = share
        self._fed[row] = fed_mm_per_s

    def logs(self) -> list[Logs]:
        """Return the steps of each lane."""
        each = {loop: self._lanes.logs(loop) for loop in self._loops}
        return [dict(zip(each, own, strict=True)) for own in zip(*each.values(), strict=True)]

    def traces(self) -> list[Trace]:
        """Return what happened in each lane."""
        whole = self._temperatures, self._sensed, self._active, self._amperes, self._fed
        found = []
        for lane, steps in enumerate(self.logs()):
            self._temperatures, self._sensed, self._active, self._amperes, self._fed = (
                each[..., lane] for each in whole
            )
            found.append(self.trace(steps))
        return found
