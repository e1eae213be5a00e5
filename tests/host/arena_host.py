"""The host builds as arenas of the mutation engine: their C, and all that judges a host build."""

from collections.abc import Callable, Mapping
from pathlib import Path

import host_specs
import host_watch
from host_control import control_problem, prepare_control
from host_gate import gate_problem, on_time_problem, switching_problem
from host_power import answers_problem, power_problem, prepare_answers
from host_specs import BuildArena, sources_of
from host_values import all_text_problems, limits_problem, types_problem
from storage_host import ordered_wrongly
from storage_settings import SettingsKept

from heatwright.sim.host import Host

Judge = Callable[[Host], str]
FIRST_COURSES = 25  # most of what can be killed is dead after them


class HostArena(BuildArena):
    def __init__(self, spec: str) -> None:
        super().__init__(f"host/{spec}", lambda: host_specs.spec_of(spec))
        self.spec = spec

    def sources(self) -> Mapping[str, str]:
        build = self.built
        files = {name: text for name, text in sources_of(build).items() if name.endswith(".c")}
        if build.controller.outputs[build.parts.heater].kind == "pwm":
            del files[f"output_{build.parts.heater}.c"]  # of timers, which this computer has not
        files.pop("countdown.c", None)  # broken in the panel's arenas, which set a time by keys
        return files

    def prepare(self) -> None:
        host = Host(self.built)
        prepare_control(host, self.spec)
        if self.spec in host_specs.COMMANDED:
            prepare_answers(self.spec)
        if self.spec in host_specs.PROGRAMMED:
            power_problem(host, self.spec)  # the reference takes all courses
        host.close()

    def problem(self, built: Path) -> str:
        host = self.host(built)
        judges = [*judges_of(self.spec, FIRST_COURSES).values(), judges_of(self.spec)["control"]]
        return next((problem for judge in judges if (problem := judge(host))), "")


def judges_of(name: str, courses: int | None = None) -> dict[str, Judge]:
    """Return what judges a host build, the quick ones first.

    name -- of its specification; courses -- how many the reference is compared over; else all.
    """
    judges: dict[str, Judge] = {
        "control": lambda host: control_problem(host, name, courses), "gate": gate_problem,
        "current": host_watch.current_problem, "proof": host_watch.proof_problem,
        "on_time": on_time_problem, "inputs": host_watch.inputs_problem, "limits": limits_problem,
        "lockout": host_watch.lockout_problem, "restored": host_watch.restored_problem,
        "text": all_text_problems, "types": types_problem,
        "settings": lambda host: SettingsKept(host, short=True).problem(),
    }  # fmt: skip
    if name in host_specs.COMMANDED:
        judges["answers"] = lambda host: answers_problem(host, name)
    if name in host_specs.SWITCHING or name in host_specs.PROGRAMMED:
        judges["switching"] = switching_problem
    if name in host_specs.PROGRAMMED:
        judges["noted"] = lambda host: next(ordered_wrongly(host), "")
        judges["power"] = lambda host: power_problem(host, name)
    return judges


ARENAS = [HostArena(name) for name in host_specs.NAMES]
