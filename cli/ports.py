"""Serial ports that a board may be plugged into."""

import time

from heatwright.cli.ends import Refused

WAIT_S = 30.0
"""Time to wait for a board whose port appears only after its reset button was pressed."""
_LOOK_S = 0.2


def found(*, waits: bool = False) -> str:
    """Return the one port with a board or an adapter plugged in.

    waits -- wait for the port to appear. Raises Refused: there is none, or more than one.
    """
    until = time.monotonic() + WAIT_S
    ports = _plugged()
    while waits and not ports and time.monotonic() < until:
        time.sleep(_LOOK_S)
        ports = _plugged()
    if not ports:
        raise Refused("No board was found: plug it in, or name its port with --port.")
    if len(ports) > 1:
        raise Refused(f"Several ports were found: name one with --port: {', '.join(ports)}.")
    return ports[0]


def _plugged() -> list[str]:
    """List the ports of adapters and boards: only these have a USB vendor number."""
    from serial.tools.list_ports import comports  # noqa: PLC0415 - slow to import

    return sorted(port.device for port in comports() if port.vid is not None)
