"""One machine of a campaign, drawn at random from the campaign's seed and its run's number.

Each quantity has its own random stream, from seed, run and name: runs can be drawn in any order and
on any computer, and varying one more quantity does not change the others.
"""

import zlib
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from heatwright.sim.campaign.breaks import BREAKS, applicable
from heatwright.sim.campaign.vary import Spread, Vary, spread_of
from heatwright.sim.plants import supplied
from heatwright.sim.scenario import end_s
from heatwright.spec import Controller, Event, Link, Simulation, ThermalNetwork
from heatwright.spec.base import ReadOnlyDict

FAULTS_SHARE = 0.6
"""Faults without a given time occur in this first part of the scenario, so that rules can trip."""
NOISE_SEEDS = 2**63


class Asked(NamedTuple):
    """A setpoint that an operator sets."""

    at_s: float
    loop: str
    setpoint_c: float


class Upsetting(NamedTuple):
    """A node jumps by some kelvin, or the controller loses its power for some seconds."""

    at_s: float
    node: str | None
    amount: float


class Broken(NamedTuple):
    """A fault and the loop on which it occurs."""

    at_s: float
    name: str
    loop: str


class Drawn(NamedTuple):
    """A run's machine and the events that are drawn for it.

    controller -- with the drawn machine; powered -- the same with the drawn supply voltage, which
    its firmware does not know; errors -- of sensors (K) and of current sensors (share); values --
    all drawn values by column, None for what does not happen in this run.
    """

    run: int
    controller: Controller
    powered: Controller
    errors: Mapping[str, float]
    noise_seed: int
    asks: tuple[Asked, ...]
    upsets: tuple[Upsetting, ...]
    fault: Broken | None
    values: Mapping[str, float | str | None]


def link_name(link: Link) -> str:
    """Return a link's name, made of its ends as in a campaign's file."""
    return "-".join(link.between)


def breakable(controller: Controller, vary: Vary) -> list[tuple[str, str]]:
    """Return the possible faults, each with its loop."""
    if vary.faults is None:
        return []
    names = vary.faults.of or tuple(BREAKS)
    return [(name, loop) for name in names for loop in applicable(controller, name)]


class _Draws:
    """Draws one quantity after the other, and records the values."""

    def __init__(self, seed: int, run: int) -> None:
        self._entropy = (seed, run)
        self.values: dict[str, float | str | None] = {}

    def stream(self, name: str) -> np.random.Generator:
        return np.random.default_rng((*self._entropy, zlib.crc32(name.encode())))

    def of(self, column: str, spread: Spread | None, own: float = 0.0) -> float:
        """Draw a quantity. A quantity that does not vary keeps its own value, and has no column."""
        if spread is None:
            return own
        self.values[column] = value = spread.draw(self.stream(column), own)
        return value

    def happens(self, name: str, chance_percent: float) -> bool:
        return float(self.stream(f"{name} happens").random()) * 100 < chance_percent

    def forget(self, *columns: str) -> None:
        """Record None in these columns: their event does not happen in this run."""
        self.values.update(dict.fromkeys(columns))


def draw(controller: Controller, vary: Vary, seed: int, run: int) -> Drawn:
    """Draw the machine of a run, and its events; the controller must have a simulation."""
    simulation = controller.simulated
    draws = _Draws(seed, run)
    network, errors = _network(simulation.plant, vary, draws), _errors(controller, vary, draws)
    ambient_c = draws.of("ambient_c", vary.ambient_c, simulation.ambient_c)
    supply = draws.of("supply_percent", vary.supply_percent, 100.0) / 100
    scenario = tuple(_late(simulation, vary, draws))
    changed = simulation.model_copy(
        update={"ambient_c": ambient_c, "plant": network, "scenario": scenario}
    )
    drawn = controller.model_copy(update={"simulation": changed})
    return Drawn(
        run=run,
        controller=drawn,
        powered=supplied(drawn, supply),
        errors=errors,
        noise_seed=int(draws.stream("noise of sensors").integers(NOISE_SEEDS)),
        asks=tuple(_asks(vary, draws)),
        upsets=tuple(_upsets(vary, draws)),
        fault=_fault(controller, vary, draws),
        values=draws.values,
    )


def _network(plant: ThermalNetwork, vary: Vary, draws: _Draws) -> ThermalNetwork:
    nodes = {
        name: draws.of(f"capacity.{name}", spread_of(vary.capacities, name), own)
        for name, own in plant.nodes.items()
    }
    links = [
        link.model_copy(update={"resistance_k_per_w": draws.of(
            f"resistance.{link_name(link)}", spread_of(vary.resistances, link_name(link)),
            link.resistance_k_per_w,
        )})
        for link in plant.links
    ]  # fmt: skip
    sense = {
        name: each.model_copy(update={"noise_k": draws.of(
            f"noise.{name}_k", spread_of(vary.noise_k, name), each.noise_k,
        )}) if each.node is not None else each
        for name, each in plant.sense.items()
    }  # fmt: skip
    return plant.model_copy(
        update={"nodes": ReadOnlyDict(nodes), "links": tuple(links), "sense": ReadOnlyDict(sense)}
    )


def _errors(controller: Controller, vary: Vary, draws: _Draws) -> dict[str, float]:
    """Draw the errors of the sensors, K; of current sensors as a share of the current."""
    found = {}
    for name, sensor in controller.sensors.items():
        own = 1.0 if sensor.measures_current else 0.0
        column = f"error.{name}" if own else f"error.{name}_k"
        spread = spread_of(vary.errors, name)
        if spread is None or (spread.is_share != bool(own)):
            continue  # `all` means all temperature sensors, or all current sensors
        found[name] = draws.of(column, spread, own) - own
        draws.values[column] = found[name]
    return found


def _late(simulation: Simulation, vary: Vary, draws: _Draws) -> Iterator[Event]:
    """Delay each event at random, but keep their order."""
    before_s, length_s = 0.0, end_s(simulation.scenario)
    for number, event in enumerate(simulation.scenario, 1):
        if event.at_s is None:
            yield event
            continue
        late_s = draws.of(f"late.{number}_s", vary.late_s)
        before_s = min(length_s, max(before_s, event.at_s + late_s))
        yield event.model_copy(update={"at_s": before_s})


def _asks(vary: Vary, draws: _Draws) -> Iterator[Asked]:
    for number, ask in enumerate(vary.asks, 1):
        name = f"ask.{number}"
        if draws.happens(name, ask.chance_percent):
            at_s = draws.of(f"{name}.at_s", ask.at_s)
            yield Asked(at_s, ask.loop, draws.of(f"{name}.setpoint_c", ask.setpoint_c))
        else:
            draws.forget(f"{name}.at_s", f"{name}.setpoint_c")


def _upsets(vary: Vary, draws: _Draws) -> Iterator[Upsetting]:
    for number, upset in enumerate(vary.upsets, 1):
        name = f"upset.{number}"
        column = f"{name}.by_k" if upset.node else f"{name}.power_cut_s"
        if draws.happens(name, upset.chance_percent):
            at_s = draws.of(f"{name}.at_s", upset.at_s)
            yield Upsetting(at_s, upset.node, draws.of(column, upset.by_k or upset.power_cut_s))
        else:
            draws.forget(f"{name}.at_s", column)


def _fault(controller: Controller, vary: Vary, draws: _Draws) -> Broken | None:
    if vary.faults is None:
        return None
    choices = breakable(controller, vary)
    if not draws.happens("fault", vary.faults.chance_percent):
        draws.forget("fault", "fault.loop", "fault.at_s")
        return None
    name, loop = choices[int(draws.stream("fault").integers(len(choices)))]
    draws.values.update({"fault": name, "fault.loop": loop})
    most_s = FAULTS_SHARE * end_s(controller.simulated.scenario)
    at_s = vary.faults.at_s or Spread("between", (0.0, most_s), False, "")
    return Broken(draws.of("fault.at_s", at_s), name, loop)
