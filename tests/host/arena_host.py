"""The host builds as arenas of the mutation engine: their C, and all that judges a host build."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import host_specs
from host_builds import build_of, sources_of
from host_control import control_problem, prepare_control
from host_gate import gate_problem
from host_kept import kept_problem
from host_orders import orders_problem
from host_output import output_problem
from host_power import power_problem, prepare_power
from host_ready import ready_problem
from host_storage import storage_problem
from host_switching import switching_problem
from host_text import all_text_problems

from heatwright.sim.host import Host

Judge = Callable[[Host], str]
FIRST_COURSES = 25
"""Most of what can be killed is dead after them."""


@dataclass(frozen=True)
class HostArena:
    spec: str
    together: bool = True

    @property
    def name(self) -> str:
        return f"host/{self.spec}"

    def sources(self) -> Mapping[str, str]:
        files = sources_of(build_of(self.spec, sanitized=False))
        return {name: text for name, text in files.items() if name.endswith(".c")}

    def headers(self) -> Mapping[str, str]:
        return sources_of(build_of(self.spec, sanitized=False))

    def build(self, changed: Mapping[str, str], folder: Path) -> Path:
        build = build_of(self.spec, sanitized=False)
        for name, text in changed.items():
            build = build.with_changed(name, text, folder)
        return build.library

    def prepare(self) -> None:
        host = Host(build_of(self.spec, sanitized=False))
        prepare_control(host, self.spec)
        if self.spec in host_specs.PROGRAMMED:
            prepare_power(host, self.spec)
        host.close()

    def problem(self, built: Path) -> str:
        host = Host(replace(build_of(self.spec, sanitized=False), library=built))
        return next((problem for judge in self._judges() if (problem := judge(host))), "")

    def _judges(self) -> list[Judge]:
        name = self.spec
        judges: list[Judge] = [
            lambda host: control_problem(host, name, FIRST_COURSES), gate_problem, all_text_problems,
            storage_problem, kept_problem,
        ]  # fmt: skip
        if name in host_specs.HOSTED and name in host_specs.WITH_AIR:
            judges.append(ready_problem)
        if name in host_specs.SWITCHING:
            judges.append(switching_problem)
        judges.append(lambda host: control_problem(host, name))
        if name in host_specs.AT_ONCE:
            judges.append(output_problem)
        if name in host_specs.BY_PEOPLE:
            judges += [orders_problem, lambda host: power_problem(host, name)]
        return judges


ARENAS = [HostArena(name) for name in host_specs.NAMES]
