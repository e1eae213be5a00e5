"""The LinuxCNC side of a Modbus slave: mb2hal's configuration, HAL files, a PyVCP panel."""

from heatwright.generator.plan.linuxcnc.bus import bus_names
from heatwright.generator.plan.linuxcnc.hal import hal_names
from heatwright.generator.plan.linuxcnc.panel import panel_names
from heatwright.generator.plan.parts import File
from heatwright.generator.plan.source import Source
from heatwright.spec import ModbusRtu

FOLDER = "linuxcnc"
"""Folder in the project; copy its files into LinuxCNC's configuration, or use them there."""


def files(source: Source, interface: ModbusRtu) -> tuple[File, ...]:
    """Plan the files; source -- the place of `interface` in the spec."""
    name = source.controller.identity.name
    hal = hal_names(source, interface)
    bus, panel = bus_names(source, interface), panel_names(source)
    return (
        File(f"{FOLDER}/{name}.hal", "linuxcnc/loops.hal.j2", hal),
        File(f"{FOLDER}/{name}_alone.hal", "linuxcnc/alone.hal.j2", hal),
        File(f"{FOLDER}/{name}_mb2hal.ini", "linuxcnc/mb2hal.ini.j2", bus),
        File(f"{FOLDER}/{name}_panel.hal", "linuxcnc/panel.hal.j2", panel),
        File(f"{FOLDER}/{name}_panel.xml", "linuxcnc/panel.xml.j2", panel),
    )
