"""Whether heater and cooler of a loop are never on together, whatever is asked of them."""

from collections.abc import Iterator

from host_running import COLD_C, HOT_C, LONG, Running


class Cooling(Running):
    def apart(self) -> Iterator[str]:
        """Whichever is on keeps the other off, whatever is asked of both."""
        for first, reading_c in (("heater", COLD_C), ("cooler", HOT_C)):
            self.run_at(reading_c)
            self.host.world.loop_hangs = 1
            self.library.output_heater_set(100.0)
            self.library.output_cooler_set(100.0)
            heated, cooled = self.ticks(self.period_ticks)
            wanted = (first == "heater", first == "cooler")
            if (heated > 0, cooled > 0) != wanted:
                yield f"{first} was on, then both: heater {heated}, cooler {cooled} ticks"
            if self.host.world.both_on:
                yield f"{first} was on, then both: they are on together"

    def hanging(self) -> Iterator[str]:
        """A main loop that stands still leaves the cooler as it is, and lets nothing heat."""
        self.run_at(HOT_C)
        self.host.world.main_hangs = 1
        if (found := self.ticks(LONG)) != (0, LONG):
            yield f"cooling and hanging: heater {found[0]}, cooler {found[1]} of {LONG} ticks"
        self.run_at(COLD_C)
        self.host.world.main_hangs = 1
        self.library.output_cooler_set(100.0)
        self.ticks(LONG)
        heated, cooled = self.ticks(LONG)
        if heated or cooled != LONG:
            yield "heating and hanging: the cooler does not follow the heater"
