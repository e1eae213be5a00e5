"""The display's place at the bench: a person who reads it."""

from typing import Any

from heatwright.cli.bench.parts.seat import Seat
from heatwright.cli.bench.world import LiveWorld


class Reader(Seat):
    """A person who reads the display."""

    kind = "i2c_lcd"

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return the rows of text."""
        return {"rows": list(self.part(world).text)}


take = Reader
