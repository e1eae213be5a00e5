"""The sizing of each loop's heater, as text and as JSON."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from heatwright.spec import Controller, Spec
from heatwright.spec.checks.physics.sizing import wire_voltage_v
from heatwright.spec.loading.loader import problem_of
from heatwright.spec.physics.reserve import Reserve, reserves, small_reserves
from heatwright.spec.physics.sized import SizedWall, SizedWire, sized_wall, sized_wire
from heatwright.spec.problems import Problem
from heatwright.spec.quantity import about, celsius

Row = tuple[str, str, str]
"""A row of the table: text, value, unit."""


class Sized(NamedTuple):
    """The sizing of one loop's heater."""

    reserve: Reserve
    walls: tuple[SizedWall, ...]
    wire: SizedWire | None
    measured_c: float | None

    @property
    def loss_w(self) -> float:
        """Heat through all walls, W."""
        return sum(wall.loss_w for wall in self.walls)


def sized(controller: Controller) -> Iterator[Sized]:
    """Size each loop that has to heat to its highest setpoint."""
    simulation = controller.simulated
    for reserve in reserves(controller):
        sizing = simulation.sizing.get(reserve.loop)
        ends_c = reserve.setpoint_c, reserve.ambient_c
        walls = tuple(sized_wall(wall, *ends_c) for wall in sizing.walls) if sizing else ()
        heater: Any = controller.outputs[reserve.heater]
        wire = sizing.wire if sizing else None
        voltage_v = wire_voltage_v(wire, heater) if wire else None
        found = None
        if wire is not None and voltage_v is not None:
            air_c = reserve.setpoint_c if wire.air_c is None else wire.air_c
            found = sized_wire(wire, heater.power_w, voltage_v, air_c)
        yield Sized(reserve, walls, found, wire.measured_c if wire else None)


def small(spec: Spec) -> Iterator[Problem]:
    """Warn of the heaters that have less than the recommended reserve."""
    for finding in small_reserves(spec.controller):
        yield problem_of(spec.tree, finding)


def reserve_json(reserve: Reserve) -> dict[str, object]:
    """Return a reserve as JSON data; a share of 30 % is 0.3."""
    return {
        "loop": reserve.loop,
        "power_W": reserve.power_w,
        "needed_W": reserve.needed_w,
        "reserve": reserve.share,
        "recommended_W": list(reserve.recommended_w),
        "resistance_K_per_W": reserve.resistance_k_per_w,
        "setpoint": reserve.setpoint_c,
        "ambient": reserve.ambient_c,
    }


def sized_json(found: Sized) -> dict[str, object]:
    """Return the sizing of a loop as JSON data."""
    wire = None if found.wire is None else {**found.wire._asdict(), "measured_c": found.measured_c}
    return {
        "plant": reserve_json(found.reserve),
        "walls": [wall._asdict() for wall in found.walls],
        "walls_W": found.loss_w if found.walls else None,
        "wire": wire,
    }


def rows(found: Sized) -> Iterator[Row]:
    """List the rows of a loop's table."""
    reserve = found.reserve
    ends = f"{celsius(reserve.setpoint_c)}, ambient {celsius(reserve.ambient_c)}"
    yield f"power that the plant needs at {ends}", about(reserve.needed_w), "W"
    yield "  thermal resistance from sensor to ambient", about(reserve.resistance_k_per_w), "K/W"
    yield from _wall_rows(found)
    low_w, high_w = map(about, reserve.recommended_w)
    yield "power with the recommended reserve of 30 to 50 %", f"{low_w} .. {high_w}", "W"
    yield "power at full duty", about(reserve.power_w), "W"
    yield "  its reserve", f"{100 * reserve.share:.0f}", "%"
    if found.wire is not None:
        yield from _wire_rows(found.wire, found.measured_c)


def _wall_rows(found: Sized) -> Iterator[Row]:
    for number, wall in enumerate(found.walls, start=1):
        yield f"wall {number}: film inside", about(wall.inside_k_per_w), "K/W"
        yield "  its layers", about(wall.layers_k_per_w), "K/W"
        yield "  film and radiation outside", about(wall.outside_k_per_w), "K/W"
        total = wall.inside_k_per_w + wall.layers_k_per_w + wall.outside_k_per_w
        yield "  in total", about(total), "K/W"
        yield "  its outer surface", about(wall.surface_c), "°C"
        yield "  heat through it", about(wall.loss_w), "W"
    if found.walls:
        yield "heat through all walls", about(found.loss_w), "W"
        yield "  the plant's need minus this", f"{found.reserve.needed_w - found.loss_w:+.1f}", "W"


def _wire_rows(wire: SizedWire, measured_c: float | None) -> Iterator[Row]:
    yield "wire: resistance", about(wire.resistance_ohm), "Ω"
    yield "  its current at full power", about(wire.current_a), "A"
    yield "  its diameter", about(wire.diameter_mm), "mm"
    yield "  its length", about(wire.length_m), "m"
    yield f"  its temperature in air of {celsius(wire.air_c)}", about(wire.temperature_c), "°C"
    if measured_c is not None:
        yield "  measured", about(measured_c), "°C"
        yield "  computed minus measured", f"{wire.temperature_c - measured_c:+.1f}", "K"
    if wire.load_as_measured_w_per_cm2 is not None:
        load = about(wire.load_as_measured_w_per_cm2)
        yield "  surface load for the measured temperature", load, "W/cm²"
