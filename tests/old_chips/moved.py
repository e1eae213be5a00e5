"""Examples moved to an ATmega32 or ATmega16: other pins, the rest as it is."""

from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "spec" / "examples"

MOVES: dict[str, tuple[tuple[str, str], ...]] = {
    # A bare chip takes no shield: without keys the setpoint is what it begins with.
    "chamber": (
        ("board: uno", "board: {board}"),
        ("pin: A1,", "pin: PA1,"),
        ("pin: D3,", "pin: PC0,"),
        ("pin: D11,", "pin: PC1,"),
        ("  - {kind: lcd_keypad, loop: air, step: 10 K}\n", ""),
        ("    - {at: 10 s, press: up, times: 3}\n", ""),
        ("initial: 20 °C", "initial: 50 °C"),
    ),
    "press": (
        ("board: mega2560", "board: {board}"),
        ("D49", "PB4"),
        ("D52", "PA7"),
        ("D50", "PA6"),
        ("pin: D8,", "pin: PC7,"),
    ),
    "hotplate": (
        ("board: nano", "board: {board}"),
        ("D10", "PD2"),
        ("D4", "PD3"),
        ("D12", "PB0"),
        ("pin: D7,", "pin: PA0,"),
    ),
    # Both by interrupts of timer 1, while timer 2 makes the tick: all in one TIMSK.
    "extruder": (
        ("board: mega2560", "board: {board}"),
        ("pin: A13", "pin: PA5"),
        ("pin: D10,", "pin: PC0,"),
        ("pin: D9,", "pin: PC1,"),
    ),
    # Both by timers, which leaves timer 0 for the tick.
    "extruder by timers": (
        ("board: mega2560", "board: {board}"),
        ("pin: A13", "pin: PA5"),
        ("pin: D10,", "pin: PD5,"),
        ("pin: D9, frequency: 122 Hz", "pin: PD7, frequency: 488.28125 Hz"),
    ),
    # The machine's own bench had an ATmega16.
    "fabricator": (("board: atmega32", "board: {board}"),),
}


def moved(name: str, board: str) -> str:
    """Write the spec of an example for another board."""
    text = (EXAMPLES / f"{name.split(maxsplit=1)[0]}.yaml").read_text(encoding="utf-8")
    for old, new in MOVES[name]:
        assert text.count(old) == 1, (name, old)
        text = text.replace(old, new.replace("{board}", board))
    return text
