"""Machines with known numbers, and the logs they leave."""

from collections.abc import Sequence
from typing import Any

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
    nodes = {"body": f"{capacity} J/K"}
    links: list[dict[str, Any]] = [
        {"between": ["body", "ambient"], "resistance": f"{resistance} K/W"}
    ]
    if case is not None:
        nodes["shell"] = f"{case[0]} J/K"
        links = [
            {"between": ["body", "shell"], "resistance": f"{case[1]} K/W"},
            {"between": ["shell", "ambient"], "resistance": f"{resistance} K/W"},
        ]
    sense = {"node": "body", "lag": f"{lag} s", "delay": f"{delay} s", "noise": f"{noise} K"}
    return ThermalNetwork.model_validate(
        {
            "kind": "thermal_network",
            "nodes": nodes,
            "links": links,
            "heat": {"heater": "body"},
            "sense": {"sensor": sense},
        }
    )


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


def as_csv(record: Record, header: str = "time [s],temperature [°C],duty [%]") -> str:
    """The record as a file."""
    lines = [header] if header else []
    for time_s, read_c, power_w in zip(
        record.times_s, record.readings_c, record.powers_w, strict=True
    ):
        lines.append(f"{time_s:g},{read_c:.3f},{100 * power_w / POWER_W:g}")
    return "\n".join(lines) + "\n"
