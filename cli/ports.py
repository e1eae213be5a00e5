"""Serial ports that a board may be plugged into."""

from __future__ import annotations

import time

from heatwright.cli.ends import Refused

WAIT_S = 30.0
"""For a board that shows its port only after its reset button was pressed."""
_LOOK_S = 0.2


def found(*, waits: bool = False) -> str:
    """Return the one port with something plugged in.

    waits -- for it to appear. Raises Refused where there is none, or more than one.
    """
    until = time.monotonic() + WAIT_S
    ports = _plugged()
    while waits and not ports and time.monotonic() < until:
        time.sleep(_LOOK_S)
        ports = _plugged()
    if not ports:
        raise Refused("No board is plugged in, or not seen: plug it in, or name its --port.")
    if len(ports) > 1:
        raise Refused(f"Several ports are in use: name one with --port: {', '.join(ports)}.")
    return ports[0]


def _plugged() -> list[str]:
    """List the ports of adapters and boards; those built into a computer have no number."""
    from serial.tools.list_ports import comports  # noqa: PLC0415 - takes a while

    return sorted(port.device for port in comports() if port.vid is not None)
