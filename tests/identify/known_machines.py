"""Machines with known numbers, and the logs they leave."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from heatwright.sim.identify import Record
from heatwright.sim.plants.thermal_network import Plant
from heatwright.spec import ThermalNetwork

Series = NDArray[np.float64]
POWER_W = 40.0


def machine(  # noqa: PLR0917
    capacity: float = 16.7,
    resistance: float = 14.7,
    lag: float = 4.5,
    delay: float = 1.3,
    noise: float = 0.0,
    case: tuple[float, float] | None = None,
) -> ThermalNetwork:
    """A body, with a case of this capacity and resistance to the body if asked for."""
    nodes, ways = {"body": f"{capacity} J/K"}, [("body", "ambient", resistance)]
    if case is not None:
        nodes["shell"] = f"{case[0]} J/K"
        ways = [("body", "shell", case[1]), ("shell", "ambient", resistance)]
    links = [{"between": [one, other], "resistance": f"{way} K/W"} for one, other, way in ways]
    sense = {"node": "body", "lag": f"{lag} s", "delay": f"{delay} s", "noise": f"{noise} K"}
    parts = {"nodes": nodes, "links": links, "heat": {"heater": "body"}, "sense": {"sensor": sense}}
    return ThermalNetwork.model_validate({"kind": "thermal_network", **parts})


def recorded(
    network: ThermalNetwork,
    duty: Sequence[float] | Series,
    *,
    period_s: float = 1.0,
    ambient_c: float = 20.0,
    step_k: float = 0.0,
    seed: int = 0,
) -> Record:
    """What a controller logs that reads this machine, duty for duty."""
    plant = Plant(network, {"heater": POWER_W}, ambient_c=ambient_c, step_s=period_s, seed=seed)
    readings = []
    for share in duty:
        readings.append(plant.sensed_c()["sensor"])
        plant.step({"heater": share})
    read_c = np.array(readings)
    if step_k:
        read_c = np.round(read_c / step_k) * step_k
    powers_w = np.asarray(duty, dtype=float) * POWER_W
    return Record(np.arange(len(read_c)) * period_s, read_c, powers_w)


def steps(count: int = 1000, *changes: tuple[int, float]) -> Series:
    """A duty of 0 that changes to these at these rows."""
    duty = np.zeros(count)
    for row, share in changes or ((20, 0.5), (600, 0.2)):
        duty[row:] = share
    return duty


def as_csv(record: Record) -> str:
    """The record as a file."""
    rows = zip(record.times_s, record.readings_c, record.powers_w, strict=True)
    lines = [f"{t:g},{read_c:.3f},{100 * power_w / POWER_W:g}" for t, read_c, power_w in rows]
    return "\n".join(["time [s],temperature [°C],duty [%]", *lines, ""])
