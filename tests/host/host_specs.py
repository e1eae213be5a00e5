"""Specifications that, between them, take every branch of the templates under test."""

from functools import cache
from random import Random

import host_commanded
import host_programmed
import host_switched

from heatwright.spec import Spec, load_text

_TEMPLATE = """\
heatwright: 1
controller: {{name: {name}, board: {board}}}
sensors:
  air: {{kind: ds18b20, pin: {sensor}, resolution: {bits} bit}}
outputs:
  heater: {{{output}, power: 240 W}}
{fan_output}
loops:
  air:
    sensor: air
    heater: heater
{fan}
    period: {period}
    setpoint: {{initial: 20 °C, minimum: 5 °C, maximum: 70 °C, stored: {stored}}}
    algorithm: {{{algorithm}}}
    protection: {{{protection}}}
safety: {{watchdog: 250 ms}}
{interfaces}
"""

_DIGITAL = "kind: digital, pin: D3"
_PWM_8 = "kind: pwm, pin: D3, frequency: 490 Hz"
_WINDOW = "kind: time_proportional, pin: D3"
_NO_RULES = "heating: off, runaway: off, frozen: off, rising_while_off: off"
_RULES = (
    "heating: {rise: 1 K, within: 9 s}, runaway: {above: 3 K, below: 2 K, for: 4 s}, "
    "frozen: {for: 7 s}, rising_while_off: {rise: 2 K, settle: 5 s}"
)
_INTERFACES = """\
interfaces:
  - {kind: lcd_keypad, loop: air, step: 5 K}
  - {kind: serial_plotter, loop: air, baud: 9600}
"""


def _variant(
    algorithm: str,
    output: str,
    protection: str,
    *,
    period: str = "1 s",
    fan: str = "",
    stored: bool = False,
    shield: bool = False,
    board: str = "uno",
    bits: int = 12,
    sensor: str = "A1",
) -> str:
    return _TEMPLATE.format(
        name="host",
        board=board,
        bits=bits,
        sensor=sensor,
        output=output,
        fan_output=f"  fan: {{kind: digital, {fan}, runs: always}}" if fan else "",
        fan="    fan: fan" if fan else "",
        period=period,
        stored=str(stored).lower(),
        algorithm=algorithm,
        protection=protection,
        interfaces=_INTERFACES if shield else "",
    )


def _texts() -> dict[str, str]:
    """Draw the constants that no boundary hangs on; always the same ones."""
    random = Random("heatwright")  # noqa: S311

    def gains(*names: str) -> str:
        most = {"kp": 60.0, "ki": 2.0, "kd": 300.0}
        return ", ".join(f"{name}: {random.uniform(0.01, most[name]):.5g}" for name in names)

    def seconds(key: str, most: float) -> str:
        return f"{key}: {random.uniform(0.1, most):.3f} s"

    return {
        "switch_lead": _variant(
            f"kind: on_off, lead: 12 s, {seconds('lead_filter', 9)}",
            _DIGITAL,
            "maximum: 85 °C, heating: {rise: 2 K, within: 8 s}, runaway: {above: 4 K, for: 5 s}, "
            "stale_after: 3 s, frozen: {for: 6 s}, rising_while_off: {rise: 3 K, settle: 4 s}",
            fan="pin: D11",
            shield=True,
        ),
        "switch": _variant("kind: on_off", _DIGITAL, f"rise_rate: 0.7 K/s, {_RULES}", bits=11),
        "switch_lead_band": _variant(
            f"kind: on_off, hysteresis: 0.5 K, {seconds('lead', 20)}",
            f"{_DIGITAL}, active: low",
            "heating: off, runaway: {above: 1.3 K, below: 0.7 K, for: 1 s}, rise_rate: 3.3 K/s",
            period="0.9 s",
        ),
        "switch_band": _variant("kind: on_off, hysteresis: 1 K", _DIGITAL, _NO_RULES),
        "p": _variant(
            f"kind: pid, {gains('kp')}, output: {{maximum: 80 %}}",
            _PWM_8,
            "frozen: off, heating: {rise: 1.1 K, within: 12 s}, runaway: {above: 2 K, for: 6 s}",
            shield=True,
        ),
        "pi_hold": _variant(
            f"kind: pid, {gains('kp', 'ki')}, integral: {{minimum: 5 %, maximum: 60 %}}",
            f"{_WINDOW}, window: 1 s, minimum_on: 50 ms, minimum_off: 30 ms",
            f"stale_after: 200 s, {_RULES}",
            fan="pin: D11, active: low",
        ),
        "pi_run": _variant(
            f"kind: pid, {gains('kp', 'ki')}, integral: {{while_limited: run}}",
            "kind: pwm, pin: D9, frequency: 100 Hz",
            f"{_RULES}, stale_after: 2.5 s",
            period="1.25 s",
        ),
        "pd": _variant(
            f"kind: pid, {gains('kp', 'kd')}, {seconds('derivative_filter', 9)}",
            f"{_WINDOW}, window: 2 s, resolution: 20 ms, minimum_on: 100 ms",
            "frozen: off, rising_while_off: {rise: 1 K, settle: 3 s}",
        ),
        "pd_error": _variant(
            f"kind: pid, {gains('kp', 'kd')}, derivative_of: error",
            f"{_PWM_8}, active: low",
            _NO_RULES,
        ),
        "pid_hold": _variant(
            f"kind: pid, {gains('kp', 'ki', 'kd')}, {seconds('derivative_filter', 5)}",
            f"{_WINDOW}, window: 3 s, minimum_off: 70 ms",
            _RULES,
            stored=True,
            fan="pin: D11",
        ),
        "pid_error_run": _variant(
            f"kind: pid, {gains('kp', 'ki', 'kd')}, derivative_of: error, "
            "integral: {minimum: 10 %, maximum: 55.5 %, while_limited: run}, "
            "output: {minimum: 10 %, maximum: 90 %}",
            f"{_WINDOW}, window: 1.5 s",
            f"{_RULES}, rise_rate: 200 K/s, minimum: -53 °C",
            period="0.5 s",
            bits=10,
            board="mega2560",
            stored=True,
        ),
        "pid_error_hold": _variant(
            "kind: pid, kp: 7.3, ki: 0.31, kd: 41.7, derivative_of: error, "
            "derivative_filter: 3 s, output: {minimum: 5 %, maximum: 95 %}, band: 8 K",
            f"{_WINDOW}, window: 1 s",
            "runaway: {above: 5 K, for: 1.7 s}, heating: {rise: 0.5 K, within: 3 s}, "
            "frozen: {for: 2.5 s}, rising_while_off: off, rise_rate: 20 K/s, stale_after: 0.6 s",
            period="0.3 s",
            bits=9,
        ),
        "old_chip": _variant(
            f"kind: pid, {gains('kp')}",
            "kind: pwm, pin: PB3, frequency: 976.5625 Hz, active: low",
            _NO_RULES,
            board="atmega32",
            sensor="PA1",
        ),
        "old_chip_interrupts": _variant(
            f"kind: pid, {gains('kp')}",
            "kind: pwm, pin: PC0, frequency: 100 Hz",
            _NO_RULES,
            board="atmega16",
            sensor="PA1",
        ),
    }


TEXTS = _texts() | host_commanded.texts() | host_switched.texts() | host_programmed.texts()
NAMES = tuple(TEXTS)
HOSTED = (*host_commanded.texts(), "held_by_host")
PROGRAMMED = tuple(name for name, text in host_programmed.texts().items() if "programs:" in text)
BY_MASTER = tuple(name for name, text in host_switched.texts().items() if "modbus" in text)
SWITCHED = (*BY_MASTER, *host_programmed.texts())
COMMANDED = (*HOSTED, *SWITCHED)

WITH_AIR = tuple(name for name, text in TEXTS.items() if "loops:\n  air:" in text)
AT_ONCE = tuple(
    name for name, text in TEXTS.items() if "kind: digital, pin: D3, minimum_" not in text
)
SWITCHING = tuple(host_switched.texts())
BY_PEOPLE = (*PROGRAMMED, "touched")


@cache
def spec_of(name: str) -> Spec:
    return load_text(TEXTS[name], f"{name}.yaml")


def is_adjustable(name: str) -> bool:
    """Tell whether the operator may lower the critical temperature of the one loop."""
    ((_, loop),) = spec_of(name).controller.loops.items()
    return loop.protection.maximum_adjustable
