"""The user's folder for cached files, which programs can make again."""

import os
import sys
from pathlib import Path


def cache_dir() -> Path:
    """`$XDG_CACHE_HOME/heatwright`, or the system's own folder for caches.

    A relative path is ignored, as the XDG specification says.
    """
    asked = os.environ.get("XDG_CACHE_HOME", "")
    if Path(asked).is_absolute():
        base = Path(asked)
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home()))
    else:
        base = Path.home() / ".cache"
    return base / "heatwright"
