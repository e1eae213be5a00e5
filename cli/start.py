"""Entry point of the command: it answers Ctrl-C even while the rest is being imported."""

import gc
import os
import signal
import sys
from types import FrameType

BETWEEN_COLLECTIONS = 50_000
"""New objects between two runs of the garbage collector. Start-up makes about as many and keeps
them: with Python's 700, those runs took a fifteenth of the time of a short command."""


def main() -> None:
    """Run the command line; Ctrl-C during its import ends the process as it does later."""
    gc.set_threshold(BETWEEN_COLLECTIONS)
    signal.signal(signal.SIGINT, _interrupted)
    from heatwright.cli.main import main as run  # noqa: PLC0415 - slow to import

    run()


def _interrupted(_: int, __: FrameType | None) -> None:
    """End at once: a module that is being imported might catch an exception."""
    if "--json" in sys.argv:
        os.write(1, b'{"status": 130, "error": "Interrupted.", "problems": []}\n')
    os.write(2, b"Interrupted.\n")
    os._exit(128 + signal.SIGINT)


if __name__ == "__main__":
    main()
