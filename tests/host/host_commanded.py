"""Specifications of loops that a G-code host commands, for `host_specs`."""

from importlib.resources import files

_TEMPLATE = """\
heatwright: 1
controller: {{name: host, board: {board}}}
sensors:
  air: {{{sensor}}}
outputs:
  heater: {{{output}, power: 40 W}}
loops:
  air:
    sensor: air
    heater: heater
    period: {period}
    setpoint: {{initial: {initial}, minimum: {minimum}, maximum: {maximum}, stored: {stored}}}
    algorithm: {{{algorithm}}}
{more}
    protection: {{{protection}}}
safety: {{watchdog: 250 ms}}
interfaces:
  - {{kind: gcode, baud: 115200, loops: {{T0: air}}}}
"""

_NTC = (
    "kind: thermistor, pin: A13, divider: {pull_up: 4.7 kΩ}, "
    "curve: {resistance: 100 kΩ, at: 25 °C, beta: 4267 K}, range: 0 °C .. 300 °C, oversample: 4"
)
_PT100 = (
    "kind: rtd, pin: A0, element: pt100, amplifier: {gain: 33.33, excitation: 3.3 V, "
    "series: 3.3 kΩ}, reference: 3.3 V, range: 2 °C .. 262 °C, oversample: 16"
)
_DS18B20 = "kind: ds18b20, pin: A1"


def _variant(
    sensor: str,
    output: str,
    algorithm: str,
    protection: str,
    *,
    board: str,
    period: str,
    setpoints: tuple[str, str, str],
    more: str = "",
    stored: bool = False,
) -> str:
    initial, minimum, maximum = setpoints
    return _TEMPLATE.format(
        sensor=sensor, output=output, algorithm=algorithm, protection=protection, board=board,
        period=period, initial=initial, minimum=minimum, maximum=maximum,
        more=f"    {more}" if more else "", stored=str(stored).lower(),
    )  # fmt: skip


def _example(name: str) -> str:
    return files("heatwright.spec.examples").joinpath(f"{name}.yaml").read_text(encoding="utf-8")


def texts() -> dict[str, str]:
    """Loops that can be tuned and loops that cannot, and the two examples as they are."""
    return {
        "tuned_hot": _variant(
            _NTC,
            "kind: pwm, pin: D11, frequency: 30 Hz, supply: 18 V, rated: 12 V",
            "kind: pid, kp: 9.41, ki: 0.345, kd: 31.4, derivative_filter: 1 s, band: 10 K, "
            "integral: {minimum: 23.5 %, maximum: 58.8 %}, output: {maximum: 90 %}",
            "maximum: 285 °C, minimum: 5 °C, rise_rate: 20 K/s, stale_after: 1 s, "
            "heating: {rise: 2 K, within: 4 s}, runaway: {above: 5 K, below: 4 K, for: 2 s}, "
            "frozen: {for: 2 s}, rising_while_off: {rise: 8 K, settle: 1 s}",
            board="mega2560",
            period="100 ms",
            setpoints=("30 °C", "20 °C", "260 °C"),
            more="autotune: {swing: 80 %, timeout: 30 s}",
            stored=True,
        ),
        "tuned_slow": _variant(
            _DS18B20,
            "kind: time_proportional, pin: D3, window: 1 s",
            "kind: pid, kp: 4, ki: 0.02, derivative_of: error, derivative_filter: 0.5 s, "
            "dead_band: 0.5 K, "
            "integral: {minimum: 5 %, while_limited: run}, output: {minimum: 2 %}",
            "heating: off, frozen: {for: 90 s}, rise_rate: 3 K/s, stale_after: 20 s, "
            "runaway: {above: 25 K, for: 3 s}, rising_while_off: off",
            board="uno",
            period="1 s",
            setpoints=("0 °C", "0 °C", "70 °C"),
            more="autotune: {cycles: 3, timeout: 20 min}\n    ready_within: 0.75 K",
        ),
        "tuned_mean": _variant(
            f"{_DS18B20}, moving_average: 3",
            "kind: time_proportional, pin: D3, window: 1 s",
            "kind: pid, kp: 4, ki: 0.02, kd: 20",
            "heating: off, frozen: {for: 90 s}, rise_rate: 3 K/s, stale_after: 20 s, "
            "runaway: {above: 25 K, for: 3 s}, rising_while_off: off",
            board="uno",
            period="1 s",
            setpoints=("0 °C", "0 °C", "70 °C"),
            more="autotune: {cycles: 3, timeout: 20 min}",
        ),
        "by_hand": _variant(
            _PT100,
            "kind: pwm, pin: D9, frequency: 1 kHz, active: low",
            "kind: pid, kp: 11.3, ki: 0.4, kd: 66, dead_band: 0.1 K, band: 25 K",
            "maximum: 260 °C, minimum: 5 °C, rise_rate: 20 K/s, stale_after: 1 s, "
            "heating: {rise: 2 K, within: 5 s}, runaway: off, frozen: off",
            board="nano",
            period="250 ms",
            setpoints=("40 °C", "30 °C", "220 °C"),
            more="ready_within: 1 K",
        ),
        "switched_by_host": _variant(
            _DS18B20,
            "kind: digital, pin: D3",
            "kind: on_off, hysteresis: 0.5 K",
            "runaway: {above: 2 K, below: 2 K, for: 3 s}, heating: {rise: 1 K, within: 6 s}",
            board="uno",
            period="1 s",
            setpoints=("30 °C", "5 °C", "70 °C"),
            stored=True,
        ),
        "extruder": _example("extruder"),
        "feeder": _example("feeder"),
    }
