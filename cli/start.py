"""What a shell starts: deaf to nothing, while all else is still being imported."""

from __future__ import annotations

import os
import signal
import sys
from types import FrameType


def main() -> None:
    """Run the command line; until it is there, Ctrl-C ends the process as it does later."""
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
