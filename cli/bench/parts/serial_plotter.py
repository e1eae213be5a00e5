"""The seat of a serial plotter: it shows the plotter's lines of numbers."""

from heatwright.cli.bench.parts.seat import Line, Seat
from heatwright.cli.bench.world import LiveWorld


class Plotter(Seat):
    """A person who watches a plotter's lines."""

    kind = "serial_plotter"

    def lines(self, world: LiveWorld) -> list[Line]:
        """Return the lines of numbers since the last call."""
        plotter, since_s = self.part(world), world.device.powered_s
        found = [
            Line(since_s + each.time_s, True, " ".join(f"{value:g}" for value in each.values))
            for each in plotter.lines
        ]
        plotter.lines.clear()
        return found


take = Plotter
