"""Whether a loop is ready only for what was asked of it last: a command counts before its step."""

from collections.abc import Callable, Iterator

from host_scale import Sixteenths, scale_of

from heatwright.sim.host import Command, Host

FAULT = 6
TARGET_C = 50.0
OTHER_C = 50.25
"""Within what counts as ready of the target, too."""


def ready_problem(host: Host) -> str:
    """Say the first thing that is wrong; empty if nothing, or if no host commands the loop."""
    if not host.build.parts.commanded:
        return ""
    return next(_problems(host), "")


def _problems(host: Host) -> Iterator[str]:
    library = host.library
    commands: dict[str, Callable[[], object]] = {
        "another setpoint": lambda: library.loop_air_set(OTHER_C),
        "off": lambda: library.loop_air_set(0.0),
        "a fault": lambda: library.fault_trip(FAULT, TARGET_C),
    }
    if host.build.parts.tunable:
        commands["by hand"] = lambda: library.loop_air_set_manual(20.0)
    if host.build.parts.autotune:
        commands["tuning"] = lambda: library.loop_air_tune(TARGET_C, 5)
    for name, command in commands.items():
        _reach(host)
        if not library.loop_air_is_ready():
            yield "it is not ready at its setpoint"
        command()
        if library.loop_air_is_ready():
            yield f"{name}: it is ready before the step that takes it over"
    yield from _edges(host)
    _power_up(host)
    if library.loop_air_is_ready():
        yield "it is ready before it has a reading"
    if host.build.parts.tunable:
        yield from _back_from_manual(host)


def _edges(host: Host) -> Iterator[str]:
    """Where codes fall on the edge: ready on it, not a step beyond."""
    within_k = host.build.controller.loops["air"].ready_within_k
    if within_k is None or not isinstance(scale_of(host.build.controller), Sixteenths):
        return
    for beyond_k, ready in ((0.0, True), (1 / 16, False)):
        for side in (-1, 1):
            _reach(host, side * (within_k + beyond_k))
            if host.library.loop_air_is_ready() != ready:
                yield f"{side * (within_k + beyond_k)} K from its setpoint it is not {ready}"


def _back_from_manual(host: Host) -> Iterator[str]:
    _reach(host)
    host.command(Command.MANUAL, 20.0)
    host.step()
    host.library.loop_air_set(TARGET_C)
    if host.library.loop_air_is_ready():
        yield "back from manual it is ready before its step"
    host.step()
    if not host.library.loop_air_is_ready():
        yield "back from manual it is not ready after its step"


def _power_up(host: Host) -> None:
    host.erase()
    host.power_up()


def _reach(host: Host, off_by_k: float = 0.0) -> None:
    _power_up(host)
    host.set_reading(0, scale_of(host.build.controller).code(TARGET_C + off_by_k))
    host.command(Command.SET, TARGET_C)
    host.step()
