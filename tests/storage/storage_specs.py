"""Machines with programs, small enough that every cut can be tried."""

from pathlib import Path

from rig.specs import files_of, spec_of

from heatwright.generator import write
from heatwright.sim.host import HostBuild, build_host

TEXT = """\
heatwright: 1
controller: {{name: stored, board: {board}}}
sensors:
  chamber: {{{sensor}}}
outputs:
  element: {{kind: time_proportional, pin: D3, window: 1 s, power: 240 W}}
loops:
  chamber:
    sensor: chamber
    heater: element
    period: 1 s
    setpoint: {{initial: 20 °C, minimum: -5 °C, maximum: 90.5 °C}}
    algorithm: {{kind: pid, kp: 8, ki: 0.02}}
    protection:
      maximum: 110 °C
      rise_rate: 10 K/s
      runaway: {{above: 15 K, for: 60 s}}
{protection}
programs:
  loop: chamber
{programs}
  stored:
    - name: "dry ~[1]"
      segments:
        - {{to: 60.5 °C, over: 90 min}}
        - {{hold: until operator}}
    - name: a
      segments:
        - {{to: 40 °C, at: as fast as possible}}
        - {{hold: 31 h}}
        - {{to: -5 °C, at: 12.5 K/h}}
interfaces:
  - {{kind: lcd_keypad, loop: chamber}}
"""

_PROGRAMS = {
    "few": "  points: 3\n  save_every: 5 min",
    "many": "  places: 8\n  points: 20\n  save_every: 3 min",
    "usual": "  after_power_loss: {resume_within: 30 K, otherwise: stop}",
    "pausing": "  after_power_loss: {resume_within: 0 K, otherwise: pause}\n  save_every: 10 min\n"
    "  points: 4",
}
_PROGRAMS["typed"] = _PROGRAMS["usual"]
_CHIP = "kind: ds18b20, pin: A1"
_CONVERTER = (
    "kind: max31856, chip_select: D22, clock: D23, data_in: D24, data_out: D25, "
    "thermocouple: J, selectable: [T, J, E]"
)
_ADJUSTABLE = ("few", "many", "typed")
_BOARDS = {
    "few": "uno",
    "many": "mega2560",
    "usual": "mega2560",
    "pausing": "uno",
    "typed": "mega2560",
}
NAMES = tuple(_PROGRAMS)


def text_of(name: str) -> str:
    adjustable = "      maximum_adjustable: true" if name in _ADJUSTABLE else ""
    return TEXT.format(
        board=_BOARDS[name],
        sensor=_CONVERTER if name == "typed" else _CHIP,
        programs=_PROGRAMS[name],
        protection=adjustable,
    )


def build_of(name: str, folder: Path, *, sanitized: bool = True) -> HostBuild:
    """Make the host build in a folder; a mutant may overflow, so its is not sanitized."""
    write(files_of(text_of(name)), folder / name)
    controller = spec_of(text_of(name)).controller
    return build_host(folder / name, controller, folder / name / "host", sanitized=sanitized)
