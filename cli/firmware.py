"""From a spec to the binary that PlatformIO builds, without leaving files with the user."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from heatwright.cli.talk import Job
from heatwright.cli.targets import blaming

if TYPE_CHECKING:
    from heatwright.generator.toolchain import BuildResult
    from heatwright.spec import Spec


def build_firmware(spec: Spec, job: Job) -> BuildResult:
    """Generate and build; the binary stays in the cache.

    Raises ToolMissing, BuildFailed.
    """
    from heatwright.generator import plan_firmware, render, write  # noqa: PLC0415
    from heatwright.generator.toolchain import BuildFailed, build  # noqa: PLC0415
    from heatwright.spec.user_cache import cache_dir  # noqa: PLC0415

    with TemporaryDirectory(prefix="heatwright-") as parent:
        folder = Path(parent) / spec.controller.identity.name
        with blaming(folder):
            write(render(plan_firmware(spec)), folder)
        try:
            with blaming(cache_dir()):
                built = build(folder, progress=job.note)
        except BuildFailed as error:
            raise BuildFailed(str(error).replace(str(folder), spec.file_name), error.log) from None
    job.end("as built before" if built.cached else "built")
    return built
