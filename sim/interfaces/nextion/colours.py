"""Colours of a Nextion display: 16 bits, five of red, six of green, five of blue."""

Colour = tuple[int, int, int]

WHITE = 65_535


def rgb(colour: int) -> Colour:
    """Return red, green and blue, 0 to 255 each."""
    red, green, blue = colour >> 11 & 31, colour >> 5 & 63, colour & 31
    return red * 255 // 31, green * 255 // 63, blue * 255 // 31
