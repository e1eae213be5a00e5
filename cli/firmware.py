"""Builds a spec's binary with PlatformIO, in the cache: the user's folder gets no files."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from heatwright.cli.options import print_json
from heatwright.cli.talk import Job
from heatwright.cli.targets import blaming

if TYPE_CHECKING:
    from heatwright.generator.toolchain import BuildResult
    from heatwright.spec import Spec


def build_firmware(spec: Spec, job: Job) -> BuildResult:
    """Generate and build the firmware; the binary stays in the cache.

    Raises ToolMissing, BuildFailed, DoesNotFit: the board is too small.
    """
    from heatwright.generator import plan_firmware, render, write  # noqa: PLC0415
    from heatwright.generator.toolchain import BuildFailed, CompilerFailed, TooLarge, build  # noqa: PLC0415
    from heatwright.spec.loading.user_cache import cache_dir  # noqa: PLC0415

    with TemporaryDirectory(prefix="heatwright-") as parent:
        folder = Path(parent) / spec.controller.identity.name
        with blaming(folder):
            write(render(plan_firmware(spec)), folder)
        try:
            with blaming(cache_dir()):
                built = build(folder, progress=job.note)
        except TooLarge as error:
            from heatwright.cli.fits import DoesNotFit, misfit  # noqa: PLC0415 - seldom needed

            raise DoesNotFit(misfit(spec, error)) from None
        except CompilerFailed as error:
            log = _kept(error.log.replace(str(folder), spec.file_name), cache_dir(), folder.name)
            raise BuildFailed(
                f"{spec.file_name}: its firmware could not be compiled. The spec is good, so this "
                f"is a bug of heatwright or of the compiler: please report it, with\n{log}, "
                "which has all messages of the compiler.",
                error.log,
            ) from None
        except BuildFailed as error:
            raise BuildFailed(str(error).replace(str(folder), spec.file_name), error.log) from None
    job.end("as built before" if built.cached else "built")
    return built


@contextmanager
def told_as_json(as_json: bool, file: Path, spec: Spec, **keys: Any) -> Iterator[None]:
    """With --json, print one JSON object for a firmware that does not fit its board."""
    from heatwright.cli.fits import DoesNotFit  # noqa: PLC0415

    try:
        yield
    except DoesNotFit as error:
        if as_json:
            print_json(spec=str(file), digest=spec.digest, **keys, **error.what.as_json())
        raise


def _kept(log: str, cache: Path, name: str) -> Path:
    """Write the compiler's messages to a file, and return its path."""
    file = cache / "logs" / f"{name}.log"
    with blaming(file):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"{log}\n", encoding="utf-8")
    return file
