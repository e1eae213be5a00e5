"""What a shell starts: deaf to nothing, while all else is still being imported."""

from __future__ import annotations

import gc
import os
import signal
import sys
from types import FrameType

BETWEEN_COLLECTIONS = 50_000
"""Objects that are made until garbage is looked for. What starts up makes as many, and keeps them:
with Python's 700 a fifteenth of the time of a short command went into looking through them."""


def main() -> None:
    """Run the command line; until it is there, Ctrl-C ends the process as it does later."""
    gc.set_threshold(BETWEEN_COLLECTIONS)
    signal.signal(signal.SIGINT, _interrupted)
    from heatwright.cli.main import main as run  # noqa: PLC0415 - takes a while

    run()


def _interrupted(_: int, __: FrameType | None) -> None:
    """End at once: an exception might be lost in whatever is being imported."""
    if "--json" in sys.argv:
        os.write(1, b'{"status": 130, "error": "Interrupted.", "problems": []}\n')
    os.write(2, b"Interrupted.\n")
    os._exit(128 + signal.SIGINT)


if __name__ == "__main__":
    main()
