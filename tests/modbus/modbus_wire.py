"""A bare line to a slave: what goes in to the bit, and what comes out."""

import re
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray
from rig.avr import whole
from rig.specs import changed, controller_of

from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_bus import Bus, Frame
from heatwright.sim.interfaces.modbus_frames import framed
from heatwright.sim.interfaces.modbus_rtu import format_of
from heatwright.sim.native.characters import Format
from heatwright.sim.native.pins import pin_number
from heatwright.spec import Controller, modbus_of

ANSWER_S = 0.005
"""An answer begins within this long after the silence that ends its request."""
SETTLE_CHARACTERS = 100
"""What the unplugged master had on the line is over by then."""


CALM = {
    "fabricator": (
        ("{rise: 5 K, within: 30 s}", "off"),
        ("{above: 20 K, for: 60 s}", "off\n      frozen: off\n      rising_while_off: off"),
        (", current: {sensor: current, limit: 3 A}", ""),
        ("  current: {kind: current, pin: PA1, scale: 0.2 V/A, oversample: 4}\n", ""),
        (", current: {of: heater}", ""),
    ),
    "dryer": (
        ("{rise: 2 K, within: 2 min}", "off"),
        ("{above: 8 K, for: 1 min}", "off\n      frozen: off\n      rising_while_off: off"),
    ),
}
"""The rules that judge the machine off: its temperature stands still, for nobody simulates it."""


def powered(
    name: str, baud: int | None = None, *replaced: tuple[str, str], warm_c: float = 45.0
) -> tuple[Controller, AvrDevice]:
    """Return an example, with another speed of its line and other parts, in a processor.

    All its sensors are as warm.
    """
    text = changed(name, *replaced)
    if baud is not None:
        text = re.sub(r"\bbaud: \d+", f"baud: {baud}", text)
    controller = controller_of(text)
    device = AvrDevice(controller, whole(text))
    for sensor in controller.thermometers:
        device.sense(sensor, warm_c)
    return controller, device


@dataclass(frozen=True)
class Sent:
    """A frame for the line: its bytes, the bits turned over in each, the silence before each, s."""

    data: bytes
    flips: tuple[int, ...] = ()
    gaps_s: tuple[float, ...] = ()
    form: Format | None = None
    baud: int | None = None


class Wire:
    """The bare line of an example: its own master is unplugged.

    address -- the slave's; frames -- what has come from the board; slowest_s -- the longest an
    answer has begun after the silence.
    """

    def __init__(
        self, name: str, baud: int | None = None, *replaced: tuple[str, str],
        warm_c: float = 45.0, start_s: float = 1.0,
    ) -> None:  # fmt: skip
        self.controller, self.device = powered(name, baud, *replaced, warm_c=warm_c)
        self.device.unplug()
        self.device.advance(start_s)
        interface = modbus_of(self.controller)
        assert interface is not None
        driver = None
        if interface.driver_enable is not None:
            driver = pin_number(self.controller.board.pins[interface.driver_enable].port_name)
        form, device = format_of(interface), self.device
        self.address = interface.address
        self.bus = Bus(device.avr, device.uart, interface.baud, form, driver)
        self.frames: list[Frame] = []
        self.slowest_s = 0.0
        device.record(self)
        self.run_to(device.avr.time_s + SETTLE_CHARACTERS * self.character_s)

    def feed(self, pins: NDArray[Any], sent: NDArray[Any]) -> None:
        self.frames += self.bus.feed(pins, sent)

    @property
    def character_s(self) -> float:
        return self.bus.form.bits / self.bus.baud

    def put(self, sent: Sent) -> float:
        """Send a frame; return when it will have ended, s."""
        gaps_s = sent.gaps_s or 0.0
        return self.bus.send(
            sent.data, form=sent.form, baud=sent.baud, gap_s=gaps_s, flips=sent.flips
        )

    def ask(self, sent: Sent) -> Frame | None:
        """Send a frame and wait for its answer, as long as one may take to begin."""
        self.frames.clear()
        end_s = self.put(sent)
        return self.answer_since(end_s)

    def answer_since(self, end_s: float) -> Frame | None:
        """Wait for the answer to what ended then."""
        self.run_to(end_s + self.bus.silence_s + ANSWER_S)
        while self.bus.hears and not self.frames:
            self.run_to(self.device.avr.time_s + self.bus.silence_s)
        if not self.frames:
            return None
        frame = self.frames.pop(0)
        self.slowest_s = max(self.slowest_s, frame.start_s - end_s - self.bus.silence_s)
        return frame

    def answers(self, pdu: bytes) -> bool:
        """Whether a good request is answered now."""
        return self.ask(Sent(framed(self.address, pdu))) is not None

    def counter(self, name: str) -> int:
        return int(self.device.read(f"modbus_counters.{name}"))

    def run_for(self, seconds: float) -> None:
        self.run_to(self.device.avr.time_s + seconds)

    def run_to(self, time_s: float) -> None:
        self.device.avr.run_to(round(time_s * self.device.avr.clock_hz))
        self.device.feed()
