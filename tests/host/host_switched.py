"""Specifications of loops that a master switches, that cool, and whose current is watched.

A current of 0.2 V/A on an ADC of 5 V, four codes to a sum, is (codes + 2) · 25/4096 A: a number
that single precision holds, so that courses meet the rules' limits to the last bit.
"""

from typing import NamedTuple


class _Variant(NamedTuple):
    heater: str
    algorithm: str
    protection: str
    period: str = "100 ms"
    loop: str = ""
    stored: bool = False
    cooler: str = ""
    measured: bool = False
    interface: str = "modbus_rtu"
    fan: bool = False
    sensor: str = (
        "kind: rtd, pin: A0, element: pt1000, divider: {pull_up: 2 kΩ}, "
        "range: -10 °C .. 400 °C, oversample: 8"
    )
    setpoint_maximum: str = "250 °C"

    @property
    def text(self) -> str:
        lines = [
            "heatwright: 1",
            "controller: {name: host, board: uno}",
            "sensors:",
            f"  air: {{{self.sensor}}}",
            *(["  amps: {kind: current, pin: A1, scale: 0.2 V/A}"] * self.measured),
            "outputs:",
            f"  heater: {{{self.heater}, power: 37.5 W}}",
            *([f"  cooler: {{kind: digital, pin: D7{self.cooler}}}"] * bool(self.cooler)),
            *(["  fan: {kind: digital, pin: D8, runs: always}"] * self.fan),
            "loops:",
            "  air:",
            "    sensor: air",
            "    heater: heater",
            *(["    cooler: cooler"] * bool(self.cooler)),
            *(["    fan: fan"] * self.fan),
            f"    period: {self.period}",
            f"    setpoint: {{initial: 30 °C, minimum: 0 °C, maximum: {self.setpoint_maximum}, "
            f"stored: {str(self.stored).lower()}}}",
            f"    algorithm: {{{self.algorithm}}}",
            *([f"    {self.loop}"] * bool(self.loop)),
            f"    protection: {{minimum: -5 °C, rise_rate: 60 K/s, {self.protection}}}",
            "safety: {watchdog: 250 ms}",
            *(["interfaces:", f"  - {{kind: {self.interface}}}"] * bool(self.interface)),
        ]
        return "\n".join(lines) + "\n"


_RULES = (
    "stale_after: 1 s, heating: {rise: 2 K, within: 4 s}, runaway: {above: 9 K, for: 2 s}, "
    "frozen: {for: 3 s}, rising_while_off: {rise: 8 K, settle: 1 s}"
)
_LIMITED = "supply: 12 V, current: {sensor: amps, limit: 1.25 A}"
_PWM = "kind: pwm, pin: D3, frequency: 490 Hz"


def texts() -> dict[str, str]:
    return {name: variant.text for name, variant in _variants().items()}


def _variants() -> dict[str, _Variant]:
    return {
        "three_limited": _Variant(
            f"{_PWM}, {_LIMITED}",
            "kind: three_position, dead_band: 2 K, hysteresis: 0.75 K, lead: 1.3 s, "
            "lead_filter: 0.4 s",
            f"{_RULES}, master_lost_after: 5 s",
            loop="starts: disabled",
            cooler=", active: low",
            measured=True,
        ),
        "three_watched": _Variant(
            "kind: digital, pin: D3, supply: 12 V, current: {sensor: amps, trip: 8 A}",
            "kind: three_position, dead_band: 3 K, lead: 0.7 s",
            _RULES,
            period="250 ms",
            cooler=", active: high",
            measured=True,
            interface="",
        ),
        "three_held": _Variant(
            "kind: digital, pin: D3",
            "kind: three_position, dead_band: 2.5 K, hysteresis: 2.5 K",
            f"{_RULES}, master_lost_after: 600 s",
            period="200 ms",
            stored=True,
            cooler=", active: high",
            fan=True,
        ),
        "three_window": _Variant(
            "kind: time_proportional, pin: D3, window: 1 s",
            "kind: three_position, dead_band: 3 K",
            "stale_after: 3 s, heating: off, runaway: off, frozen: off, rising_while_off: off",
            period="1 s",
            cooler=", active: high",
            interface="",
            sensor="kind: ds18b20, pin: A2, moving_average: 4",
            setpoint_maximum="80 °C",
        ),
        "tuned_by_master": _Variant(
            f"{_PWM}, {_LIMITED}",
            "kind: pid, kp: 9.41, ki: 0.345, kd: 31.4, derivative_filter: 1 s, band: 10 K, "
            "output: {maximum: 90 %}",
            f"{_RULES}, master_lost_after: 1 s",
            loop="autotune: {swing: 80 %, timeout: 30 s}",
            stored=True,
            measured=True,
        ),
        "pid_by_master": _Variant(
            f"{_PWM}",
            "kind: pid, kp: 4.1, ki: 0.2",
            "stale_after: 1 s, heating: off, runaway: off, frozen: off",
            loop="ready_within: 2.5 K",
        ),
        "switched_by_master": _Variant(
            "kind: digital, pin: D3, minimum_on: 2 s",
            "kind: on_off, hysteresis: 0.5 K",
            "stale_after: 1 s, heating: off, runaway: off, frozen: {for: 3 s}, "
            "rising_while_off: {rise: 8 K, settle: 3 s}, master_lost_after: 400 ms",
            loop="starts: disabled",
        ),
        "held_by_host": _Variant(
            "kind: digital, pin: D3, minimum_on: 2 s, minimum_off: 300 ms",
            "kind: on_off",
            "stale_after: 1 s, heating: off, runaway: off, frozen: off, rising_while_off: off",
            interface="gcode, loops: {T0: air}",
        ),
    }
