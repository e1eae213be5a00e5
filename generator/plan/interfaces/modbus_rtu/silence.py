"""The silence between two frames of a Modbus line."""

from heatwright.spec import ModbusRtu

SILENT_CHARACTERS = 3.5
"""Silence that ends a frame (MODBUS over serial line 1.02, section 2.5.1.1)."""
FASTEST_COUNTED_BAUD = 19_200
"""Above this baud rate the silence is a fixed time, as the same section recommends."""
FIXED_SILENCE_S = 0.00175


def silence_s(interface: ModbusRtu) -> float:
    """Return the silence that ends a frame, s."""
    if interface.baud > FASTEST_COUNTED_BAUD:
        return FIXED_SILENCE_S
    return SILENT_CHARACTERS * interface.character_bits / interface.baud
