"""The builds of `host_specs`, each made once in a folder."""

from functools import cache
from pathlib import Path

import host_specs

from heatwright.generator import plan_firmware, render, write
from heatwright.sim.host import HostBuild, build_host


@cache
def build_of(name: str, folder: Path) -> HostBuild:
    spec = host_specs.spec_of(name)
    project = folder / name
    write(render(plan_firmware(spec)), project)
    return build_host(project, spec.controller, project / "host")


@cache
def plain_build_of(name: str, folder: Path) -> HostBuild:
    """Without the sanitizer, which would end the process at a mutant's first overflow."""
    spec = host_specs.spec_of(name)
    project = folder / name
    write(render(plan_firmware(spec)), project)
    return build_host(project, spec.controller, project / "plain", sanitized=False)
