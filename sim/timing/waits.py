"""The longest busy waits, the longest times with interrupts off, and the stack."""

from collections.abc import Iterable

from heatwright.sim.binary.elf import Elf
from heatwright.sim.binary.profile import FunctionProfile, Profile, line_ranges
from heatwright.sim.timing.figures import BUSY_US, SLOT_US, Cost, Figure

ONE_WIRE = "one_wire"
"""Beginning of the names of the 1-Wire buses' source files."""
MOST_EXPENSIVE = 10


class Files:
    """The source file of each function."""

    def __init__(self, program: Elf) -> None:
        self._program = program
        self._of: dict[str, str] = {}
        for start, _, file, _ in line_ranges(program.path):
            function = program.function_at(start)
            if function is not None:
                self._of.setdefault(function.name, file)

    def label(self, function: str) -> str:
        """Return the function's name; for an interrupt, which has only a number, with its file."""
        file = self._of.get(function)
        return f"{function} ({file})" if file and function.startswith("__vector_") else function

    def is_slot(self, function: str) -> bool:
        """Whether the function is the interrupt of a 1-Wire bus."""
        file = self._of.get(function, "")
        return function.startswith("__vector_") and file.startswith(ONE_WIRE)


def busy(profile: Profile, files: Files) -> Figure:
    """Return the longest time within eight words of code without sleep, µs."""
    found = profile.busy
    return Figure("busy waiting", "µs", 1e6 * found.seconds, BUSY_US, files.label(found.function))


def masked(profile: Profile, files: Files, clock_hz: int, limit_us: float) -> dict[str, Figure]:
    """Return the longest times with interrupts off, µs: outside 1-Wire slots, and in them.

    limit_us -- the limit outside slots, from the interrupts' needs; in slots it is SLOT_US.
    """
    functions = profile.functions
    slots = {name: each for name, each in functions.items() if files.is_slot(name)}
    rest = {name: each for name, each in functions.items() if name not in slots}
    figures = {
        "longest_interrupts_off_us": _longest("interrupts off", rest, limit_us, files, clock_hz)
    }
    if slots:
        figures["longest_one_wire_slot_us"] = _longest(
            "interrupts off in a 1-Wire slot", slots, SLOT_US, files, clock_hz
        )
    return figures


def _longest(
    what: str, functions: dict[str, FunctionProfile], limit_us: float, files: Files, clock_hz: int
) -> Figure:
    name = max(functions, key=lambda each: functions[each].masked, default="")
    cycles = functions[name].masked if name else 0
    return Figure(what, "µs", cycles * 1e6 / clock_hz, limit_us, files.label(name))


def stack(used: int, worst: int) -> Figure:
    """Compare the used stack with the worst case from the analysis of the code, bytes."""
    return Figure("stack used, of the worst found in the code", "bytes", float(used), float(worst))


def costs(profile: Profile, files: Files, cycles: int) -> tuple[Cost, ...]:
    """Return the functions with the longest calls; their own cycles are a share of all cycles."""
    found: Iterable[tuple[str, FunctionProfile]] = profile.functions.items()
    longest = sorted(found, key=lambda each: -each[1].longest)[:MOST_EXPENSIVE]
    return tuple(
        Cost(files.label(name), each.calls, each.longest, 100 * each.own / cycles)
        for name, each in longest
    )
