"""Characters of an HD44780 with character ROM A00, by code (Hitachi data sheet, table 4)."""

OWN = "■"
"""Placeholder for a character that the program has drawn itself (codes 0 to 15)."""

_ASCII = "".join(map(chr, range(0x20, 0x7E))).replace("\\", "¥") + "→←"
_KATAKANA = "".join(map(chr, range(0xFF61, 0xFF9F))) + "°"
_REST = "αäβεμσρg√⁻jˣ¢£ñöpqθ∞ΩüΣπx̄y千万円÷ █"
"""Codes 0xE0 to 0xFF; the x with a bar takes two characters and is replaced by an x."""

A00 = OWN * 16 + " " * 16 + _ASCII + " " * 32 + " " + _KATAKANA + _REST.replace("x̄", "x")
"""256 characters; programs use code 0xDF, the katakana voicing circle, as degree sign."""
