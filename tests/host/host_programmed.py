"""Specifications of loops that programs move, and of one that people switch, for `host_specs`.

Their programs are short, and at temperatures that a sixteenth of a kelvin meets: courses reach
every limit to the bit.
"""

_TEMPLATE = """\
heatwright: 1
controller: {{name: host, board: {board}}}
sensors:
  air: {{{sensor}, moving_average: {readings}}}
outputs:
  heater: {{{output}, power: 60 W}}
{relay}
loops:
  air:
    sensor: air
    heater: heater
    period: {period}
    setpoint: {{initial: 30 °C, minimum: 5 °C, maximum: {most}, stored: {stored}}}
    algorithm: {{{algorithm}}}
{more}
    protection: {{{protection}}}
{programs}
safety: {{watchdog: 250 ms{safety}}}
interfaces:
  - {{{interface}, loop: air}}
"""

_STORED = """\
  stored:
    - name: ways
      segments:
        - {to: 40 °C, over: 8 s}
        - {hold: 4 s}
        - {to: 30 °C, at: 6300 K/h}
        - {to: 36 °C, at: as fast as possible}
        - {hold: until operator}
        - {to: 30.3 °C, over: 3 s}
    - name: one ~
      segments: [{to: 45.5 °C, over: 2 s}]
    - name: hold only
      segments: [{hold: 1 s}, {hold: 5 s}]
    - name: level
      segments: [{to: 33 °C, over: 4 s}, {to: 33 °C, over: 4 s}, {to: 33 °C, at: 0.1 K/h}]
    - name: down
      segments: [{to: 20 °C, at: as fast as possible}, {to: 10 °C, at: 6553.5 K/h}, {hold: 2 s}]
    - name: slow
      segments: [{to: MOST °C, at: 0.1 K/h}, {to: 5 °C, over: 744 h}]
    - name: quick
      segments:
        - {to: 10.1 °C, over: 2 s}
        - {to: 31.3 °C, at: 6553.5 K/h}
        - {hold: 1 s}
        - {hold: until operator}
"""
"""The eighth place is empty."""

_KEYS = "kind: lcd_keypad, step: 1 K"
_MAX31856 = "kind: max31856, chip_select: D49, clock: D52, data_in: D51, data_out: D50"
_WINDOW = "kind: time_proportional, pin: D3"


def _variant(
    output: str,
    algorithm: str,
    protection: str,
    *,
    period: str,
    programs: tuple[str, ...] = (),
    readings: int = 1,
    sensor: str = "kind: ds18b20, pin: A1",
    stored: bool = False,
    interface: str = _KEYS,
    more: str = "",
    relay: bool = False,
    most: str = "70 °C",
    board: str = "mega2560",
) -> str:
    stored_programs = _STORED.replace("MOST °C", most)
    section = ["programs:", "  loop: air", "  points: 6", "  places: 8"]
    section += [f"  {each}" for each in programs]
    return _TEMPLATE.format(
        board=board,
        readings=readings,
        sensor=sensor,
        output=output,
        relay="  relay: {kind: digital, pin: D7}" if relay else "",
        period=period,
        stored=str(stored).lower(),
        most=most,
        algorithm=algorithm,
        more=f"    {more}" if more else "",
        protection=protection,
        programs="\n".join(section) + "\n" + stored_programs if programs else "",
        safety=", relay: relay, relay_feedback: D8" if relay else "",
        interface=interface,
    )


def texts() -> dict[str, str]:
    """Every way in which programs may run, and a loop that a display switches without any."""
    return {
        "fired": _variant(
            f"{_WINDOW}, window: 1 s",
            "kind: pid, kp: 7.6, ki: 0.126, kd: 51, derivative_filter: 2 s, feed_forward: 95.3",
            "maximum_adjustable: true, runaway: {above: 6 K, below: 5 K, for: 5 s}, "
            "heating: {rise: 1 K, within: 12 s}, frozen: {for: 15 s}, "
            "rising_while_off: {rise: 3 K, settle: 8 s}",
            period="1 s",
            programs=(
                "hold_back: {within: 4 K, limit: 9 s}",
                "after_power_loss: {resume_within: 5 K, otherwise: pause}",
                "save_every: 50 s",
            ),
            readings=5,
        ),
        "fired_held": _variant(
            "kind: digital, pin: D3, minimum_on: 2 s",
            "kind: on_off, hysteresis: 0.5 K, lead: 3 s",
            "runaway: off, heating: off, frozen: off, rising_while_off: off",
            period="0.8 s",
            programs=("hold_back: off", "after_power_loss: stop"),
            stored=True,
            sensor=_MAX31856,
            most="800 °C",
        ),
        "fired_simply": _variant(
            "kind: pwm, pin: D46, frequency: 100 Hz",
            "kind: pid, kp: 11.5, feed_forward: 0.7, dead_band: 0.25 K, integral: {maximum: 40 %}",
            "runaway: {above: 3 K, for: 2.5 s}, heating: off, frozen: off, rising_while_off: off",
            period="0.5 s",
            sensor="kind: ds18b20, pin: A1, resolution: 10 bit",
            programs=(
                "hold_back: {within: 2 K, limit: 4 s}",
                "reached_within: 0.75 K",
                "after_power_loss: {resume_within: 3 K, otherwise: stop}",
                "at_end: hold",
                "save_every: 51 s",
            ),
            readings=3,
            more="starts: enabled",
        ),
        "fired_never_again": _variant(
            f"{_WINDOW}, window: 2 s, resolution: 20 ms, distribution: spread",
            "kind: pid, kp: 5, kd: 30, output: {minimum: 2 %}, feed_forward: 12",
            "runaway: {above: 11 K, for: 3 s}, heating: off, frozen: off",
            period="1 s",
            programs=(
                "after_power_loss: {resume_within: 0 K, otherwise: pause}",
                "at_end: hold",
            ),
        ),
        "touched": _variant(
            f"{_WINDOW}, window: 1 s",
            "kind: pid, kp: 5, ki: 0.2",
            "maximum_adjustable: true, heating: off, frozen: off",
            period="1 s",
            stored=True,
            interface="kind: nextion",
            relay=True,
            sensor=f"{_MAX31856}, selectable: [K, S]",
        ),
    }
