"""Builds the C of a loop: features add statements at places, and functions."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields

from heatwright.generator.plan.loop.names import LoopNames
from heatwright.generator.plan.parts import Header

STAGES = ("begin", "read", "program", "guard", "decide", "limit", "drive", "report")
"""The stages of a control step, in order."""
PLACES = (*STAGES, "start", "tick", "follow", "set", "refuse", "switch_off", "disable")
"""The places where features add statements."""


def always(_: LoopNames) -> bool:
    """Return True: every loop has the feature."""
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class Feature:
    """C that one feature adds to a loop; `{name}` is replaced by the template's value `name`."""

    when: Callable[[LoopNames], object] = always
    """Whether a loop has the feature."""
    each: Callable[[LoopNames], Iterable[str]] = lambda _: ("",)
    """The feature is added once for each of these, as `{each}`."""
    names: Mapping[str, str] = field(default_factory=dict)
    """Values for templates and statements; they replace those of the same name set earlier."""
    includes: Mapping[str, str] = field(default_factory=dict)
    """Headers, and the symbols for which they are included."""
    helpers: tuple[str, ...] = ()
    """Names of templates in the folder loop/step: functions that the control step calls."""
    public: tuple[str, ...] = ()
    """Names of templates in the folder loop/public: functions that other parts call."""
    begin: str = ""
    """Runs at the start of a step: applies settings and commands since the last step."""
    read: str = ""
    program: str = ""
    guard: str = ""
    decide: str = ""
    limit: str = ""
    drive: str = ""
    report: str = ""
    start: str = ""
    """Runs at the start of the firmware."""
    tick: str = ""
    """Runs after the step."""
    follow: str = ""
    """Runs in each step in which a program is not idle; the program may be paused."""
    set: str = ""
    """Runs when a host sets a setpoint."""
    refuse: str = ""
    """A condition under which a setpoint is refused."""
    switch_off: str = ""
    """Runs when the loop goes off, for any reason."""
    disable: str = ""
    """Runs when the loop is switched off by a command."""


@dataclass(frozen=True, slots=True)
class LoopFile:
    """The contents of a loop's C file, from its features."""

    includes: list[Header]
    helpers: list[str]
    public: list[str]
    named: Mapping[str, str]
    at: Mapping[str, list[str]]
    """The statements at each place."""
    step: str


def put_together(loop: LoopNames, features: Iterable[Feature]) -> LoopFile:
    """Collect the C of the loop's features, in their order."""
    had = [each for each in features if each.when(loop)]
    known = {each.name: getattr(loop, each.name) for each in fields(loop)}
    named = {key: text.format(**known) for each in had for key, text in each.names.items()}
    known |= named
    symbols = defaultdict[str, list[str]](list)
    at: dict[str, list[str]] = {place: [] for place in PLACES}
    for feature in had:
        for each in feature.each(loop):
            for header, symbol in feature.includes.items():
                symbols[header.format(**known, each=each)].append(symbol.format(**known, each=each))
            for place, statements in at.items():
                added: str = getattr(feature, place)
                statements.extend(added.format(**known, each=each).splitlines())
    return LoopFile(
        includes=[Header(header, ", ".join(symbols[header])) for header in sorted(symbols)],
        helpers=[f"loop/step/{name}.c.j2" for feature in had for name in feature.helpers],
        public=[f"loop/public/{name}.c.j2" for feature in had for name in feature.public],
        named=named,
        at=at,
        step="\n\n".join("\n".join(at[stage]) for stage in STAGES if at[stage]),
    )
