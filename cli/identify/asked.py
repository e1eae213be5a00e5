"""How `identify` reads a log, according to its options or a spec."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from heatwright.cli.ends import Refused
from heatwright.cli.plot import gcode
from heatwright.sim.identify import (
    Log,
    Names,
    Record,
    Roles,
    Scales,
    Structure,
    chosen_roles,
    named_roles,
    read_log,
    record_of,
)
from heatwright.sim.identify.columns import Column, with_unit
from heatwright.sim.tuning.process import power_of, reading_age_s
from heatwright.spec import Controller, Loop, facts_of, load
from heatwright.spec.simulation import AMBIENT

PLOTTER_FULL = 10.0
"""Full duty in the plotter's lines: their unit is 10 %, so that the curve stays readable."""


@dataclass(frozen=True)
class Asked:
    """How to read a log, and the structure of the model to fit."""

    columns: str | None
    scales: Scales
    structure: Structure
    age_s: float = 0.0
    """How old a reading is at its control step, s."""
    plotter: tuple[int, int] | None = None
    """Columns of temperature and duty, and their number, in the firmware's plotter lines."""
    loop: str = ""
    """The loop of the spec; names of the log's columns may begin with its name."""
    reported: tuple[str, str] | None = None
    """Labels of temperature and duty in the reports to the loop's G-code host."""

    def record(self, data: bytes) -> Record:
        """Read a log; raises Unusable."""
        log = read_log(data)
        roles, scales = self.roles(log)
        return record_of(log, roles, scales)

    def roles(self, log: Log) -> tuple[Roles, Scales]:
        """Find the meaning of each column and of its numbers; raises Unusable."""
        width = log.values.shape[1]
        if self.columns is not None:
            chosen = chosen_roles(
                self.columns, log.names, width, stamped=log.stamped, loop=self.loop
            )
            return chosen, self.scales
        if not log.names and self.plotter is not None and width - log.stamped == self.plotter[1]:
            time = Column(width - 1, "s") if log.stamped else None
            scales = replace(self.scales, full=self.scales.full or PLOTTER_FULL)
            return Roles(Column(0, "°C"), time, Column(self.plotter[0], "")), scales
        if self.reported is not None and {*self.reported} <= {*log.names}:
            scales = replace(self.scales, full=self.scales.full or gcode.FULL)
            return _reported(self.reported, log.names), scales
        return named_roles(log.names, self.loop), self.scales


def asked_of(  # noqa: PLR0913 - one for each option
    spec: Path | None,
    loop: str | None,
    *,
    columns: str | None,
    power_w: float | None,
    full: float | None,
    period_s: float | None,
    bodies: int,
) -> Asked:
    """Combine options and spec; an option overrides the spec."""
    if spec is None:
        return Asked(columns, Scales(power_w, full, period_s), Structure(bodies))
    loaded = load(spec)
    controller = loaded.controller
    able = ", ".join(controller.loops)
    name = loop or next(iter(controller.loops))
    if loop is None and len(controller.loops) > 1:
        raise Refused(
            f"{loaded.file_name}: has several loops: {able}. Name the loop of this record, "
            f"such as --loop {name}."
        )
    if name not in controller.loops:
        raise Refused(f"{loaded.file_name}: has no loop {name}; there are {able}.")
    chosen = controller.loops[name]
    power_w = power_w or power_of(controller, name)
    reported = gcode.labels_of(controller, name)
    every_s = chosen.period_s if reported is None else gcode.EVERY_S
    return Asked(
        columns,
        Scales(power_w, full, period_s or every_s),
        Structure(bodies, _names(controller, chosen)),
        reading_age_s(controller, chosen.sensor),
        plotter_of(controller, name),
        name,
        reported,
    )


def _names(controller: Controller, loop: Loop) -> Names:
    body = shell = None
    if controller.simulation is not None:
        plant = controller.simulation.plant
        body = plant.sense[loop.sensor].node
        outer = {node for link in plant.links if AMBIENT in link.between for node in link.between}
        shell = next((node for node in plant.nodes if node in outer - {body}), None)
    names = Names(heater=loop.heater, sensor=loop.sensor)
    return Names(body or names.body, shell or names.shell, loop.heater, loop.sensor)


def _reported(titles: tuple[str, str], names: Sequence[str]) -> Roles:
    """Return the columns of one loop in a printer's reports, which also contain other loops."""
    temperature, duty = map(names.index, titles)
    times = (place for place, name in enumerate(names) if name.lower().startswith("time"))
    place = next(times, None)
    time = None if place is None else Column(place, with_unit(names[place])[1] or "s")
    return Roles(Column(temperature, "°C"), time, Column(duty, ""))


def plotter_of(controller: Controller, name: str) -> tuple[int, int] | None:
    """Return the duty's place in the firmware's plotter lines, and their number of fields."""
    from heatwright.generator.plan.interfaces.serial_plotter import fields  # noqa: PLC0415

    if not facts_of(controller, name).plotted:
        return None
    titles = [field.title for field in fields(controller, name)]
    places = [place for place, title in enumerate(titles) if title.startswith(("heater", "duty"))]
    return places[0], len(titles)
