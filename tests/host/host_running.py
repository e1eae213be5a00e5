"""A loop that is switched on and runs, at a temperature."""

from host_scale import scale_of

from heatwright.sim.host import Command, Host

HOT_C, COLD_C, TARGET_C = 240.0, 60.0, 150.0
LONG = 3000
"""Ticks in which every permit runs out."""


class Running:
    def __init__(self, host: Host) -> None:
        self.host = host
        self.library = host.library
        self.parts = host.build.parts
        self.scale = scale_of(host.build.controller)
        self.loop = host.build.controller.loops[self.parts.loop]
        self.period_ticks = round(self.loop.period_s * 100)
        output = host.build.controller.outputs[self.parts.heater]
        self.window_ticks = round(100 * getattr(output, "window_s", 0))

    def run_at(self, celsius: float) -> None:
        """Power up, switch on, and do a few steps at a temperature."""
        host = self.host
        host.world.main_hangs = host.world.loop_hangs = host.world.fan_stands_still = 0
        host.erase()
        host.power_up()
        host.set_reading(0, self.scale.code(celsius))
        host.set_setpoint(TARGET_C)
        host.step()
        if self.parts.switched:
            for command in (Command.DISABLE, Command.ENABLE):
                host.command(command)
                host.step()
        for _ in range(3):
            host.step()

    def ticks(self, ticks: int) -> tuple[int, int]:
        world = self.host.world
        before = world.heater_counts, world.cooler_ticks
        for _ in range(ticks):
            self.library.host_tick()
        return int(world.heater_counts - before[0]), int(world.cooler_ticks - before[1])
