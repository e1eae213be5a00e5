"""Faults of monitors: broken sensors and parts that are too warm, with their warnings."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple, cast

from heatwright.sim.circuits import Wiring
from heatwright.sim.faults.bounds import TICK_S, lasting_s, reading_s
from heatwright.sim.faults.effects import Felt, standing
from heatwright.sim.faults.fault import Act, Fault, Trip, harmless, tripping
from heatwright.sim.faults.sensing.readings import SENSOR_RULES
from heatwright.sim.faults.world import Site, World
from heatwright.sim.sensors.adc_sensor import AdcSensor
from heatwright.sim.sensors.ds18b20 import Ds18b20
from heatwright.sim.sensors.spi_chip import SpiChip
from heatwright.spec import Loop, Monitor, facts_of, watching_loop
from heatwright.spec.sensors import Thermometer

TOLD_S = 10.0
"""A warning is shown everywhere within this time and some steps: a small display alternates."""
TOLD_STEPS = 4
COLUMNS = 7
"""Columns for a monitor's name on a display of 16 columns."""


class Watched(NamedTuple):
    """A monitor, its sensor, and the loop in whose steps it is judged."""

    name: str
    monitor: Monitor
    sensor: Thermometer
    loop: Loop
    step_k: float

    @property
    def warned_c(self) -> float:
        """A temperature of the tip at which the monitor warns."""
        return self.monitor.warning_c + self.step_k

    @property
    def over_c(self) -> float:
        """A temperature of the tip at which the monitor trips, within the sensor's range."""
        limit_c = self.monitor.limit_c
        return min(limit_c + self.sensor.error_k(limit_c) + self.step_k, self.sensor.range_c[1])

    @property
    def well_c(self) -> float:
        """A temperature of the tip at which the warning ends."""
        ends_c = self.monitor.warning_c - self.monitor.hysteresis_k
        return max(ends_c - self.step_k, self.sensor.range_c[0])


def faults(site: Site) -> Iterator[Fault]:
    """Yield the faults of each monitor."""
    controller = site.controller
    for name, monitor in controller.monitors.items():
        sensor = controller.thermometers[monitor.sensor]
        loop = watching_loop(controller, name)
        assert loop is not None  # noqa: S101 - the checks ensure it
        step_k = sensor.step_at_k(monitor.warning_c, controller.board.mcu)
        watched = Watched(name, monitor, sensor, controller.loops[loop], step_k)
        yield from _broken(site, watched)
        yield _over_limit(site, watched)
        if site.controller.loops[loop].also != name:  # else `sensors_disagree` would trip
            yield _warned(site, watched)


def _broken(site: Site, watched: Watched) -> Iterator[Fault]:
    """Yield a broken and a shorted sensor wire: the heaters go off after `stale_after`."""
    allowed_s = lasting_s(watched.monitor.stale_after_s, watched.loop)
    for what in ("torn", "shorted"):
        name, torn = f"monitor_{watched.name}_{what}", _break(watched, what)
        trip = Trip(SENSOR_RULES, allowed_s)
        broken = _stops(tripping(site, name, torn, trip, _break(watched, "")), allowed_s)
        yield replace(broken, others_lie=(f"monitor_{watched.name}",))


def _stops(fault: Fault, allowed_s: float) -> Fault:
    """Demand of a monitor's fault that all heaters are off when it trips."""
    return replace(fault, off_within_s=allowed_s + TICK_S, all_off=True, again=True)


def _break(watched: Watched, what: str) -> Act:
    """Tear or short the sensor's wires; "" repairs them."""

    def act(world: World) -> None:
        part = world.device.sensors[watched.monitor.sensor]
        if watched.sensor.on_adc:
            wiring = Wiring(opened=what == "torn", shorted=what == "shorted")
            cast("AdcSensor", part).wiring = wiring
            return
        chip = cast("Ds18b20 | SpiChip", part)
        if what == "torn":
            chip.unplug()
        else:
            chip.plug()
            chip.short("low" if what else None)

    return act


def _over_limit(site: Site, watched: Watched) -> Fault:
    """Return a monitored part that becomes too hot, while no loop's sensor measures it."""
    allowed_s = reading_s(watched.loop)
    hot = Felt(watched.monitor.sensor, standing(watched.over_c))
    name, trip = f"monitor_{watched.name}_over_limit", Trip(("monitor_limit",), allowed_s)
    return _stops(tripping(site, name, hot, trip, hot.mend), allowed_s)


def _warned(site: Site, watched: Watched) -> Fault:
    """Return a part that is too warm: every interface warns, nothing trips, the warning ends."""

    def judge(world: World) -> str:
        if not world.device.read(f"monitor_{watched.name}.warns"):
            return f"monitor {watched.name} does not warn at {watched.warned_c:.1f} °C"
        told = "; ".join(untold(world))
        Felt(watched.monitor.sensor, standing(watched.well_c))(world)
        world.run(watched.loop.periods_s(3))
        if world.device.read(f"monitor_{watched.name}.warns"):
            return f"the warning of {watched.name} does not end at {watched.well_c:.1f} °C"
        return told

    warm = Felt(watched.monitor.sensor, standing(watched.warned_c))
    for_s = watched.loop.next_step_s(reading_s(watched.loop))
    return harmless(site, f"monitor_{watched.name}_warns", warm, for_s, judge)


def untold(world: World) -> Iterator[str]:
    """Yield each interface that does not show the warning of the first monitor that warns."""
    site, device = world.site, world.device
    warning = [name for name in site.controller.monitors if device.read(f"monitor_{name}.warns")]
    first = warning[0]
    within_s = TOLD_S + TOLD_STEPS * site.controller.longest_period_s
    if site.has_keys:
        end = f" {first[:COLUMNS]}!"
        if not world.until(lambda now: now.screen[1].rstrip().endswith(end), within_s):
            yield f"the display does not show {end!r}"
    if site.facts.hosted and not device.host.texts(f"echo:warning, too warm: {first} at "):
        yield f"the host got no warning of {first}"
    if facts_of(site.controller).nextion is not None:
        words = f"warm: {first}"
        if not world.until(
            lambda now: now.device.display.value("main.alarm.txt") == words, within_s
        ):
            yield f"the touch display does not show {words!r}"
    if facts_of(site.controller).modbus is not None:
        bits = sum(1 << list(site.controller.monitors).index(name) for name in warning)
        if not world.until(lambda now: now.device.master.values.get("warnings") == bits, within_s):
            yield "the master does not read the warning"
    if facts_of(site.controller).log is not None:
        device.log_reader.write("monitors")
        if not world.until(lambda now: _log_says(now, first), within_s):
            yield f"the log does not show the warning of {first}"


def _log_says(world: World, name: str) -> bool:
    texts = world.device.log_reader.texts
    return any(text.startswith(f"{name},") and text.endswith(",warning") for text in texts)
