"""Other controllers than the example, made from its text: each walks other code."""

from pathlib import Path

from heatwright.generator import plan_firmware, render, write
from heatwright.generator.toolchain import build
from heatwright.spec import Spec, load_text

CHAMBER = Path(__file__).parents[2] / "spec" / "examples" / "chamber.yaml"

# A relay module that is on at low level, PID in slow windows spread over them, a safety relay with
# its contact, a band with two ends, half the sensor's resolution, the setpoint kept; heating_failed
# off, so that sensor_frozen is the first.
PID = (
    ("heater: {kind: digital, pin: D3, power: 240 W}",
     "heater: {kind: time_proportional, pin: D3, active: low, window: 2 s, resolution: 20 ms, "
     "distribution: spread, power: 240 W}\n  contactor: {kind: digital, pin: D2, active: low}"),
    ("resolution: 12 bit", "resolution: 11 bit"),
    ("maximum: 70 °C}", "maximum: 70 °C, stored: true}"),
    ("{kind: on_off, hysteresis: 0 K, lead: 12 s, lead_filter: 4 s}",
     "{kind: pid, kp: 12, ki: 0.05, kd: 300, derivative_filter: 4 s}"),
    ("heating: {rise: 2 K, within: 120 s}", "heating: off\n      frozen: {for: 90 s}"),
    ("{above: 10 K, for: 60 s}", "{above: 10 K, below: 8 K, for: 30 s}"),
    ("watchdog: 2 s", "watchdog: 500 ms\n  relay: contactor\n  relay_feedback: D12"),
)  # fmt: skip

# A transistor under PWM, a fast loop, a short patience; no display, no keys, no fan.
BARE = (
    ("heater: {kind: digital, pin: D3, power: 240 W}",
     "heater: {kind: pwm, pin: D3, frequency: 490 Hz, power: 240 W}"),
    ("  fan: {kind: digital, pin: D11, runs: always}\n", ""),
    ("    fan: fan                       # the heater may only be on while this fan is\n", ""),
    ("initial: 20 °C", "initial: 50 °C"),
    ("period: 1 s", "period: 500 ms"),
    ("resolution: 12 bit", "resolution: 10 bit"),
    ("{kind: on_off, hysteresis: 0 K, lead: 12 s, lead_filter: 4 s}",
     "{kind: pid, kp: 20, ki: 0.1}"),
    ("stale_after: 5 s", "stale_after: 2 s"),
    ("watchdog: 2 s", "watchdog: 1 s"),
    ("  - {kind: lcd_keypad, loop: air, step: 10 K}\n", ""),
    ("    - {at: 10 s, press: up, times: 3}\n", ""),
)  # fmt: skip


def varied(name: str, changes: tuple[tuple[str, str], ...]) -> Spec:
    """The chamber's text with these changes, every one of which must apply."""
    text = CHAMBER.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return load_text(text, f"{name}.yaml")


def built(spec: Spec, folder: Path) -> Path:
    """The binary, as PlatformIO builds it."""
    write(render(plan_firmware(spec)), folder)
    return build(folder).elf
