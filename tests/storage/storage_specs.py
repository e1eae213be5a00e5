"""Machines with programs, small enough that every cut can be tried."""

from functools import cache
from pathlib import Path

from heatwright.generator import plan_firmware, render, write
from heatwright.sim.host import HostBuild, build_host
from heatwright.spec import Spec, load_text

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


@cache
def spec_of(name: str) -> Spec:
    adjustable = "      maximum_adjustable: true" if name in _ADJUSTABLE else ""
    text = TEXT.format(
        board=_BOARDS[name],
        sensor=_CONVERTER if name == "typed" else _CHIP,
        programs=_PROGRAMS[name],
        protection=adjustable,
    )  # fmt: skip
    return load_text(text, f"{name}.yaml")


@cache
def build_of(name: str, folder: Path, *, sanitized: bool = True) -> HostBuild:
    """The host build, made once in a folder; a mutant may overflow, so its is not sanitized."""
    spec = spec_of(name)
    project = folder / name
    write(render(plan_firmware(spec)), project)
    made = project / ("host" if sanitized else "plain")
    return build_host(project, spec.controller, made, sanitized=sanitized)
