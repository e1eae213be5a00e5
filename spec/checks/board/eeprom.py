"""The EEPROM: it must hold everything that is stored, and its cells must last."""

import math
from collections.abc import Callable
from itertools import islice

from heatwright.spec.board.eeprom import (
    LEAST_YEARS,
    MOST_RECORD_BYTES,
    Area,
    Layout,
    layout,
    settings_bytes,
    slowest_s,
    start_s,
)
from heatwright.spec.board.serial_log import log_in_eeprom
from heatwright.spec.boards import BOARDS
from heatwright.spec.checks.finding import Finding, Findings
from heatwright.spec.checks.loops.timing import WATCHDOG_TOLERANCE
from heatwright.spec.controller import WATCHDOG_S, Controller
from heatwright.spec.problems import Path
from heatwright.spec.quantity import about, duration

MINUTE_S = 60.0
TEN_S = 10.0
"""Messages propose times in multiples of 10 s; times above a minute in whole minutes."""


def eeprom_suffices(controller: Controller) -> Findings:
    """Find programs and logs that the EEPROM has no room for."""
    areas, room = layout(controller), controller.board.eeprom_bytes
    if areas.end <= room:
        return
    yield Finding(
        _largest(controller, areas),
        f"settings, programs and log take {areas.end} bytes, and the EEPROM of the "
        f"{controller.identity.board} has {room}: {areas.end - room} too many ({_shares(areas)})",
        _smaller(controller),
        (("controller", "board"), ("programs",), ("interfaces",)),
    )


def settings_fit(controller: Controller) -> Findings:
    """Check that the stored settings of all loops together fit into one record."""
    size = settings_bytes(controller)
    if size <= MOST_RECORD_BYTES:
        return
    yield Finding(
        ("loops",),
        "what the loops store (setpoints, gains, limits, numbers that keys set) takes "
        f"{size} bytes, and a record in the EEPROM holds at most {MOST_RECORD_BYTES} bytes",
        "Delete the key `stored` or `limits_adjustable` in some loops, or use fewer loops",
    )


def _largest(controller: Controller, areas: Layout) -> Path:
    """Return the path of the largest user of the EEPROM that can be made smaller."""
    log = log_in_eeprom(controller)
    kept = areas.history.slot_bytes * areas.history.slots
    if log is not None and kept > areas.programs.slot_bytes * areas.programs.slots:
        return ("interfaces", controller.interfaces.index(log), "entries")
    return ("programs", "points")


def _shares(areas: Layout) -> str:
    """List the bytes that each area takes, the largest area first."""
    names = ("settings", "programs", "progress of the program", "log")
    sizes = {name: area.slot_bytes * area.slots for name, area in zip(names, areas, strict=True)}
    ordered = sorted(sizes.items(), key=lambda each: -each[1])
    return ", ".join(f"{name} {size}" for name, size in ordered if size)


def _smaller(controller: Controller) -> str:
    ways, programs, log = [], controller.programs, log_in_eeprom(controller)
    if programs is not None:
        least = max((len(each.segments) for each in programs.stored), default=1)
        points = _most(programs.points, lambda most: _with_points(controller, most), least)
        ways.append(f"at most {points} points, or fewer places" if points else "fewer places")
    if log is not None:
        entries = _most(log.entries, lambda most: _with_entries(controller, most))
        ways += [f"at most {entries} entries of the log"] * bool(entries) + ["keep: ram"]
    boards = (name for name in BOARDS if _suffices(on_board(controller, name)))
    ways += [f"a board with more EEPROM, such as {name}" for name in islice(boards, 1)]
    return f"Use {', or '.join(ways)}"


def _most(given: int, changed: Callable[[int], Controller], least: int = 1) -> int:
    """Return the highest number below `given` that the EEPROM has room for; 0 if below `least`."""
    return next((each for each in range(given - 1, least - 1, -1) if _suffices(changed(each))), 0)


def _suffices(controller: Controller) -> bool:
    return layout(controller).end <= controller.board.eeprom_bytes


def _with_points(controller: Controller, points: int) -> Controller:
    programs = controller.programs
    assert programs is not None  # noqa: S101 - only called if there are programs
    return controller.model_copy(
        update={"programs": programs.model_copy(update={"points": points})}
    )


def _with_entries(controller: Controller, entries: int) -> Controller:
    log = log_in_eeprom(controller)
    return controller.model_copy(
        update={
            "interfaces": tuple(
                each.model_copy(update={"entries": entries}) if each is log else each
                for each in controller.interfaces
            )
        }
    )


def on_board(controller: Controller, board: str) -> Controller:
    """Put the controller on another board, at that board's own clock."""
    identity = controller.identity.model_copy(update={"board": board, "clock_hz": None})
    return controller.model_copy(update={"identity": identity})


def progress_lasts(controller: Controller) -> Findings:
    """Find programs that save their progress so often that the EEPROM wears out."""
    programs, areas = controller.programs, layout(controller)
    if programs is None or areas.end > controller.board.eeprom_bytes:
        return
    every_s, slots = programs.save_every_s, areas.progress.slots
    if areas.progress.years(every_s) < LEAST_YEARS:
        yield Finding(
            ("programs", "save_every"),
            _worn("a program that runs day and night", areas.progress, every_s),
            f"Use save_every: {_rare_enough(slots)}, or fewer points or places",
            (("controller", "board"), ("programs",)),
        )


def log_lasts(controller: Controller) -> Findings:
    """Find logs whose few entries are written so often that the EEPROM wears out."""
    log, areas = log_in_eeprom(controller), layout(controller)
    if log is not None and areas.history.years(log.every_s) < LEAST_YEARS:
        yield Finding(
            ("interfaces", controller.interfaces.index(log), "every"),
            _worn("the log", areas.history, log.every_s),
            f"Use every: {_rare_enough(log.entries)}, or more entries, or keep: ram",
        )


def start_in_time(controller: Controller) -> Findings:
    """Check that the start finishes its search of the EEPROM before the watchdog resets."""
    seconds, watchdog_s = start_s(controller), controller.safety.watchdog_s
    if controller.programs is None or seconds < watchdog_s * (1 - WATCHDOG_TOLERANCE):
        return
    able = next(each for each in WATCHDOG_S if seconds < each * (1 - WATCHDOG_TOLERANCE))
    yield Finding(
        ("safety", "watchdog"),
        f"the watchdog may reset the chip after {duration(watchdog_s)}, while the start still "
        f"searches the EEPROM for the progress, which takes up to {about(1000 * seconds)} ms",
        f"Use at least {duration(able)}",
        (("programs",), ("controller",)),
    )


def _worn(what: str, area: Area, every_s: float) -> str:
    return (
        f"{what} wears the EEPROM out within {about(area.years(every_s))} years: "
        f"{area.slots} slots, one every {duration(every_s)}"
    )


def _rare_enough(slots: int) -> str:
    slowest = slowest_s(LEAST_YEARS, slots)
    step_s = MINUTE_S if slowest > MINUTE_S else TEN_S
    return duration(math.ceil(slowest / step_s) * step_s)
