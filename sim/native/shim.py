"""Compile and load the shim.

It is built once per machine into the user's cache (``$XDG_CACHE_HOME/heatwright/native``, default
``~/.cache``), by ``python -m heatwright.sim.native.build`` or on first use. The file name contains
a digest of the sources, of the simavr version and of this Python's ABI, so a change of any of them
causes a new build, and processes that build at the same time do not disturb each other.
"""

import contextlib
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from heatwright.spec.loading.user_cache import cache_dir

HERE = Path(__file__).parent
MODULE = "_heatwright_native"
TESTED = ("1.6",)
HEADERS = (Path("/usr/include"), Path("/usr/local/include"))


class SimulatorMissing(RuntimeError):
    """The shim cannot be built or loaded; the message is one line with the remedy."""


def _install() -> str:
    """Return the command that installs everything the simulator needs, in one go."""
    headers = Path(sysconfig.get_paths()["include"], "Python.h")
    own = f" libpython{sys.version_info.major}.{sys.version_info.minor}-dev"
    return f"sudo apt-get install libsimavr-dev gcc libc6-dev{'' if headers.is_file() else own}"


def simavr_headers() -> tuple[Path, str]:
    """Return the include folder that contains ``simavr/`` and simavr's version.

    Raises SimulatorMissing: simavr is absent or its version is untested; its timing and its
    structures change between versions.
    """
    for folder in HEADERS:
        config = folder / "simavr" / "sim_core_config.h"
        if config.is_file():
            found = re.search(r'CONFIG_SIMAVR_VERSION\s+"([^"]+)"', config.read_text())
            version = found.group(1) if found else "of unknown version"
            if version not in TESTED:
                raise SimulatorMissing(
                    f"simavr {version} is untested: install {' or '.join(TESTED)} "
                    "(Debian 12 has it: libsimavr-dev)."
                )
            return folder, version
    raise SimulatorMissing(f"simavr is not installed: {_install()}")


def _compiler() -> str:
    found = shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc")
    if not found:
        raise SimulatorMissing(f"There is no C compiler: {_install()}")
    return found


def _python_headers() -> Path:
    folder = Path(sysconfig.get_paths()["include"])
    if not (folder / "Python.h").is_file():
        raise SimulatorMissing(f"Python's headers are not installed: {_install()}")
    return folder


def _sources() -> list[Path]:
    return sorted(HERE.rglob("*.[ch]"))


def _digest(version: str) -> str:
    parts = [version, sysconfig.get_config_var("SOABI") or sys.version, sys.prefix]
    parts += [f"{path.name}\n{path.read_text()}" for path in [*_sources(), HERE / "shim.py"]]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def _glue(folder: Path) -> Path:
    """Write cffi's C for the declarations in api.h and callbacks.h."""
    from cffi import FFI  # noqa: PLC0415 - only when something is to be compiled

    ffi = FFI()
    ffi.cdef((HERE / "api.h").read_text())
    ffi.cdef(f'extern "Python+C" {{{(HERE / "callbacks.h").read_text()}}}')
    ffi.set_source(MODULE, '#include <stddef.h>\n#include <stdint.h>\n#include "api.h"\n')
    path = folder / f"{MODULE}.c"
    with contextlib.redirect_stdout(None):  # cffi prints what it writes
        ffi.emit_c_code(str(path))
    return path


def _compile(folder: Path, includes: Path) -> Path:
    output = folder / f"{MODULE}.so"
    own = [str(path) for path in _sources() if path.suffix == ".c"]
    command = [_compiler(), "-O2", "-fPIC", "-fvisibility=hidden", "-shared", "-std=gnu11", "-Wall"]
    command += ["-o", str(output), "-isystem", str(includes), "-isystem", str(includes / "simavr")]
    command += ["-isystem", str(_python_headers()), "-I", str(HERE), *own, str(_glue(folder))]
    result = subprocess.run(  # noqa: S603 - our own command
        [*command, "-lsimavr", "-lm"], capture_output=True, text=True, check=False
    )
    if result.returncode:
        why = next((line for line in result.stderr.splitlines() if "error" in line), "")
        raise SimulatorMissing(
            f"The simulator's shim does not compile ({why.strip()}): {_install()}"
        )
    return output


def _sealed(library: bytes) -> bytes:
    """Append a checksum to a library, where the loader ignores it."""
    return library + hashlib.sha256(library).digest()


def _whole(library: Path) -> bool:
    """Return whether a library is complete: loading a truncated one could end the process."""
    try:
        data = library.read_bytes()
    except OSError:
        return False
    return data == _sealed(data[: -hashlib.sha256().digest_size])


def build() -> Path:
    """Return the path of the compiled shim; build it if it is missing."""
    includes, version = simavr_headers()
    target = cache_dir() / "native" / f"{MODULE}-{_digest(version)}.so"
    if _whole(target):
        return target
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent) as folder:
            fresh = _compile(Path(folder), includes)
            fresh.write_bytes(_sealed(fresh.read_bytes()))
            fresh.replace(target)
    except OSError as error:
        raise SimulatorMissing(
            f"The simulator's shim cannot be kept in {target.parent} ({error.strerror}): "
            "set XDG_CACHE_HOME to a folder you can write."
        ) from error
    return target


@cache
def load() -> Any:
    """Return the compiled module (``.lib``, ``.ffi``), building it on first use.

    Raises SimulatorMissing: it cannot be built; the message has the remedy.
    """
    path = build()
    spec = importlib.util.spec_from_file_location(MODULE, path)
    if spec is None or spec.loader is None:
        raise SimulatorMissing(f"{path} is not a Python module: delete it and try again.")
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as error:
        raise SimulatorMissing(f"{path.name} does not load ({error}): {_install()}") from error
    return module
