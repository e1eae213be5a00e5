"""LEDs as a person sees them: bright, dark or blinking."""

from typing import Any

from heatwright.cli.bench.parts.seat import Seat
from heatwright.cli.bench.world import LiveWorld


class Lights(Seat):
    """A person who looks at LEDs."""

    kind = "indicators"

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return each LED: its pin and meaning, whether it is bright now, and what it has shown."""
        now_s = world.now_s - world.device.powered_s
        return {
            "leds": [
                {
                    "pin": pin,
                    "meaning": led.meaning,
                    "bright": led.changes[-1][1],
                    "light": led.light(now_s),
                }
                for pin, led in self.part(world).leds.items()
            ]
        }


take = Lights
