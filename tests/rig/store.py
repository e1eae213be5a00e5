"""What was compiled once: by the content of all that goes into it, in `build/rig`."""

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

STORE = Path(__file__).parents[2] / "build" / "rig"


class CompileFailed(AssertionError):
    """The compiler's words."""


@cache
def _version(compiler: str) -> str:
    return subprocess.run(
        [compiler, "--version"], capture_output=True, text=True, check=True
    ).stdout


def made(command: Sequence[str], texts: Mapping[str, str], product: str) -> Path:
    """Run a compiler in a folder with these files, and return its product, or raise CompileFailed.

    The same command with the same files is run once; the folder stays in the store.
    """
    key = repr((_version(command[0]), list(command), sorted(texts.items()), product))
    place = STORE / hashlib.sha256(key.encode()).hexdigest()[:24]
    if (place / product).exists():
        return place / product
    STORE.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="making-", dir=STORE))
    for path, text in texts.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
    done = subprocess.run(list(command), cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        shutil.rmtree(folder)
        raise CompileFailed(done.stderr)
    try:
        folder.rename(place)
    except OSError:  # another process was quicker
        shutil.rmtree(folder)
    return place / product
