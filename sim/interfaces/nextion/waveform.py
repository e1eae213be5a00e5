"""The curves of a Nextion waveform: one byte per column, up to four channels."""

from collections import deque

from heatwright.sim.interfaces.nextion.codes import Code, Refused

ALL = 255
"""The channel number that means all channels in `cle`."""


class Waveform:
    """The points of a waveform component while its page is shown.

    channels -- the newest points of each, oldest first, as many as the component is wide.
    """

    def __init__(self, width: int, channels: int) -> None:
        self.channels: tuple[deque[int], ...] = tuple(deque(maxlen=width) for _ in range(channels))

    def add(self, channel: int, value: int) -> None:
        """Add a point, 0 to 255; other values are refused (the display's manual forbids them)."""
        if not 0 <= value <= 255:
            raise Refused(Code.INVALID_OPERATION)
        self._channel(channel).append(value)

    def clear(self, channel: int) -> None:
        """Delete all points of a channel, or of all channels."""
        for each in self.channels if channel == ALL else (self._channel(channel),):
            each.clear()

    def _channel(self, channel: int) -> deque[int]:
        if not 0 <= channel < len(self.channels):
            raise Refused(Code.INVALID_WAVEFORM)
        return self.channels[channel]
