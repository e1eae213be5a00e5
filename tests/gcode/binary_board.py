"""A simulated board on whose serial line a test goes on line by line."""

from rig.avr import whole
from rig.specs import controller_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.gcode import GcodeHost


class BinaryBoard:
    """The firmware's binary; device -- the board itself."""

    def __init__(self, spec: str, **celsius: float) -> None:
        self.device = AvrDevice(controller_of(spec), whole(spec))
        self._celsius = celsius
        for sensor, degrees in celsius.items():
            self.sense(sensor, degrees)
        self.wait(1.0)
        self._heard = len(self.host.lines)

    @property
    def host(self) -> GcodeHost:
        return self.device.host

    def tell(self, line: str, seconds: float = 0.5) -> None:
        """Send a line as a person does."""
        self.host.send_bytes(line.encode() + b"\n")
        self.wait(seconds)

    def told(self, line: str, seconds: float = 0.5) -> list[str]:
        """The same, and give what is answered."""
        self._heard = len(self.host.lines)
        self.tell(line, seconds)
        return self.heard()

    def heard(self) -> list[str]:
        """Give what was said since the last time."""
        known, self._heard = self._heard, len(self.host.lines)
        return [line.text for line in self.host.lines[known:]]

    def sense(self, sensor: str, degrees: float) -> None:
        self.device.sense(sensor, degrees)

    def wait(self, seconds: float) -> None:
        self.device.advance(self.device.time_s + seconds)

    def cut(self, seconds: float = 1.0) -> None:
        """Lose the power for a moment."""
        self.device.power_cycle()
        for sensor, degrees in self._celsius.items():
            self.sense(sensor, degrees)
        self.wait(seconds)

    def on_fraction(self, output: str, seconds: float = 2.0) -> float:
        """How much of the time from now on an output is on."""
        self.device.on_fraction(output)
        self.wait(seconds)
        return self.device.on_fraction(output)

    @property
    def steps(self) -> int:
        """Where the feed is."""
        self.device.feed()
        return int(self.device.outputs["feed"].position)

    @property
    def motor_is_free(self) -> bool:
        return self.on_fraction("feed", 1.0) == 0.0
