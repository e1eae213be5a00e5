"""Masters, and hosts whose loss is detected: their writes, and loops that only a master enables."""

from collections.abc import Iterator

from heatwright.spec.checks.finding import Finding, Findings, scenario_events, untaken
from heatwright.spec.checks.loops.tenths import fits
from heatwright.spec.checks.loops.timing import can_be_counted
from heatwright.spec.checks.references import unknown
from heatwright.spec.commands import by_hand, by_host, gcode_of, modbus_of, switched, tunable
from heatwright.spec.controller import Controller
from heatwright.spec.interfaces import Gcode, ModbusRtu
from heatwright.spec.loading.suggest import listed
from heatwright.spec.problems import Path
from heatwright.spec.quantity import celsius, duration, number, rounded_up
from heatwright.spec.scenario.writes import COMMANDS, GAINS, Write

LONGEST_FRAME = 256
"""Maximum number of bytes of a request or an answer (Modbus over serial line, 2.5.1)."""

LONGEST_TALK = 96 + 2048
"""Characters of the longest line that the firmware accepts from a host, plus the longest answer."""

HOST_CHARACTER_BITS = 10
"""Bits of one character in 8N1 format: start bit, 8 data bits, stop bit."""

HOST_POLLS_S = 5.0
"""Interval at which idle OctoPrint and Printrun ask for the temperatures."""

_REMEDY = "add {kind: modbus_rtu} to interfaces"


def somebody_switches_on(controller: Controller) -> Findings:
    """Find loops that nobody can switch on, and loops that watch a master which does not exist."""
    for name, loop in controller.loops.items():
        if loop.starts == "disabled" and not switched(controller, name):
            yield Finding(
                ("loops", name, "starts"),
                "nobody could switch the loop on: there is no modbus_rtu interface, and neither "
                "keys, a display nor programs serve it",
                f"Delete it, or {_REMEDY}",
                (("interfaces",), ("programs",)),
            )
        there = modbus_of(controller) is not None or by_host(controller, name)
        if loop.protection.master_lost_after_s is not None and not there:
            yield Finding(
                ("loops", name, "protection", "master_lost_after"),
                "there is no master to lose: no modbus_rtu interface, and no gcode interface that "
                "serves this loop",
                f"Delete it, or {_REMEDY}",
                (("interfaces",),),
            )


def exchange_s(modbus: ModbusRtu) -> float:
    """Return the time of the longest request and the longest answer, s."""
    return 2 * LONGEST_FRAME * modbus.character_bits / modbus.baud


def polls_s(host: Gcode) -> float:
    """Return the time within which a healthy host has sent two requests, at the latest, s."""
    return 2 * HOST_POLLS_S + LONGEST_TALK * HOST_CHARACTER_BITS / host.baud


def masters_have_time(controller: Controller) -> Findings:
    """Check that `master_lost_after` outlasts an exchange, or a host's polls, and fits 16 bits."""
    modbus, host = modbus_of(controller), gcode_of(controller)
    for name, loop in controller.loops.items():
        seconds = loop.protection.master_lost_after_s
        path: Path = ("loops", name, "protection", "master_lost_after")
        if seconds is None:
            continue
        if modbus is not None and seconds <= exchange_s(modbus):
            needed = duration(float(rounded_up(exchange_s(modbus))))
            yield Finding(
                path,
                f"{duration(seconds)} may be over while a single long request and its answer are "
                f"on the line: at {modbus.baud} baud they take up to {needed}",
                f"Use more than {needed}, several times the master's interval between two requests",
                (("interfaces",),),
            )
        elif host is not None and seconds < polls_s(host):
            needed = duration(float(rounded_up(polls_s(host))))
            answer_s = float(rounded_up(polls_s(host) - 2 * HOST_POLLS_S))
            yield Finding(
                path,
                f"{duration(seconds)} is less than two polls of a healthy host and one long answer "
                f"may take: it polls every {duration(HOST_POLLS_S)}, and at {host.baud} baud the "
                f"answer takes up to {duration(answer_s)}",
                f"Use at least {needed}",
                (("interfaces",),),
            )
        else:
            yield from can_be_counted(path, seconds)


def writes_have_a_reader(controller: Controller) -> Findings:
    """Find writes of a master in a scenario, if no interface accepts them."""
    if modbus_of(controller) is None:
        reason = "no interface accepts writes of a master"
        remedy = "Add {kind: modbus_rtu} to interfaces, or delete the event"
        yield from untaken(controller, "write", "write", reason, remedy, ("interfaces",))


def writes_find_their_place(controller: Controller) -> Findings:
    """Find writes to undefined loops, or to values that a loop does not have."""
    if modbus_of(controller) is None:
        return
    for path, write in _writes(controller):
        if write.loop:
            yield from unknown(path, write.loop, "loops", controller.loops)
        if not write.loop or write.loop in controller.loops:
            yield from _place(controller, path, write)


def _writes(controller: Controller) -> Iterator[tuple[Path, Write]]:
    for path, event in scenario_events(controller):
        for write in event.write or ():
            yield (*path, "write", write.name), write


def _place(controller: Controller, path: Path, write: Write) -> Findings:
    because_of: tuple[Path, ...] = (("loops",), ("interfaces",))
    tuned = [name for name in controller.loops if tunable(controller, name)]
    if write.what in COMMANDS[1:] and not tuned:
        yield Finding(
            path, "no loop has gains to store or restore", "Delete it, or use pid", because_of
        )
    elif write.what in ("manual", "manual_duty", "tune", *GAINS) and write.loop not in tuned:
        kind = controller.loops[write.loop].algorithm.kind
        yield Finding(
            path,
            f"the algorithm {kind} has no gains, and its duty cannot be set by hand",
            f"Write {listed([f'{write.loop}.{what}' for what in ('setpoint', 'enabled')])}, or use "
            "pid",
            because_of,
        )
    elif write.what == "tune" and controller.loops[write.loop].autotune is None:
        yield Finding(
            path,
            f"the loop {write.loop} has no autotune",
            "Add autotune: {} to the loop, or delete tune",
            because_of,
        )


def writes_in_range(controller: Controller) -> Findings:
    """Find setpoints and duties that the controller would refuse, or could not hold."""
    for path, write in _writes(controller):
        loop = controller.loops.get(write.loop)
        if loop is None or write.what not in ("setpoint", "manual_duty"):
            continue
        low_c, high_c = loop.setpoint.minimum_c, loop.setpoint.maximum_c
        if write.what == "setpoint" and not low_c <= write.value <= high_c:
            yield Finding(
                path,
                f"{celsius(write.value)} is outside the range of setpoints",
                f"Use {celsius(low_c)} to {celsius(high_c)}",
                (("loops", write.loop, "setpoint"),),
            )
        elif write.what == "manual_duty" and not 0 <= write.value <= 100:
            yield Finding(path, f"{number(write.value)} % is no duty", "Use 0 % to 100 %")
        else:
            yield from fits(path, write.value, "°C" if write.what == "setpoint" else "%")


def written_loops_are_on(controller: Controller) -> Findings:
    """Find loops that get a setpoint, but stay off; a scenario's own file is not refused for it."""
    if modbus_of(controller) is None:
        return
    writes = list(_writes(controller))
    on = {write.loop for _, write in writes if write.what == "enabled" and write.value}
    for name, loop in controller.loops.items():
        if name in on or loop.starts == "enabled" or by_hand(controller, name):
            continue
        asked = [path for path, each in writes if each.name == f"{name}.setpoint"]
        if asked:
            yield Finding(
                ("loops", name),
                "the loop stays off in the scenario: it starts disabled, and the master writes its "
                "setpoint but never enables it",
                f"Add {name}.enabled: true to the event that writes {name}.setpoint",
                (asked[0], ("interfaces",)),
            )


def warm_is_once(controller: Controller) -> Findings:
    """Find `ready_within` that nothing uses: a master reads the dead band instead."""
    for name, loop in controller.loops.items():
        if modbus_of(controller) is None or loop.algorithm.warm_within_k is None:
            continue
        if loop.ready_within_k is not None:
            yield Finding(
                ("loops", name, "ready_within"),
                "with three_position dead_band decides whether a master reads the state warm",
                "Delete it",
                (("loops", name, "algorithm"), ("interfaces",)),
            )
