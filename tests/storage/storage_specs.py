"""Machines with programs, small enough that every cut can be tried."""

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

_CHIP = "kind: ds18b20, pin: A1"
_CONVERTER = (
    "kind: max31856, chip_select: D22, clock: D23, data_in: D24, data_out: D25, "
    "thermocouple: J, selectable: [T, J, E]"
)
_ADJUSTABLE = "      maximum_adjustable: true"
_USUAL = "  after_power_loss: {resume_within: 30 K, otherwise: stop}"
_PAUSING = (
    "  after_power_loss: {resume_within: 0 K, otherwise: pause}\n  save_every: 10 min\n  points: 4"
)
_MACHINES = {
    "few": ("uno", _CHIP, "  points: 3\n  save_every: 5 min", _ADJUSTABLE),
    "many": ("mega2560", _CHIP, "  places: 8\n  points: 20\n  save_every: 3 min", _ADJUSTABLE),
    "usual": ("mega2560", _CHIP, _USUAL, ""),
    "pausing": ("uno", _CHIP, _PAUSING, ""),
    "typed": ("mega2560", _CONVERTER, _USUAL, _ADJUSTABLE),
}
NAMES = tuple(_MACHINES)


def board_text(board: str, programs: str, sensor: str = _CHIP, protection: str = "") -> str:
    return TEXT.format(board=board, sensor=sensor, programs=programs, protection=protection)


def text_of(name: str) -> str:
    board, sensor, programs, protection = _MACHINES[name]
    return board_text(board, programs, sensor, protection)
