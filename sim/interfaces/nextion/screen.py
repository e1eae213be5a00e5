"""A Nextion display's page as a picture.

Letters are drawn with DejaVu Sans, which comes with matplotlib, at the height of the display's own
fonts: a real display has the fonts that its maker has put into the editor. All is drawn flat, as
with the editor's `style` 0.
"""

from collections.abc import Callable, Mapping
from functools import cache
from io import BytesIO
from pathlib import Path

import matplotlib as mpl
from PIL import Image, ImageDraw, ImageFont

from heatwright.sim.interfaces.nextion.display import Display
from heatwright.sim.interfaces.nextion.memory import Part
from heatwright.spec.nextion import FONTS, HEIGHT, WIDTH

Colour = tuple[int, int, int]
"""Red, green and blue, 0 to 255 each."""

WHITE = 65_535


def rgb(colour: int) -> Colour:
    """Convert a display's 16 bits: five of red, six of green, five of blue."""
    red, green, blue = colour >> 11 & 31, colour >> 5 & 63, colour & 31
    return red * 255 // 31, green * 255 // 63, blue * 255 // 31


DARK = (0, 0, 0)
CURVES = ("pco0", "pco1", "pco2", "pco3")
Box = tuple[int, int, int, int]
"""Left, top, right, bottom; right and bottom are included."""


def draw(display: Display) -> Image.Image:
    """Draw the shown page; without power the display is dark."""
    image = Image.new("RGB", (WIDTH, HEIGHT), DARK)
    if display.is_on:
        image.paste(rgb(display.ground), (0, 0, WIDTH, HEIGHT))
        canvas = _Canvas(image, display.held)
        for part in display.memory.shown():
            if part.visible:
                canvas.draw(part)
    return image


def png(display: Display) -> bytes:
    """Draw the shown page as a PNG."""
    return as_png(draw(display))


def as_png(image: Image.Image, compress_level: int = 6) -> bytes:
    """Write an image as a PNG; compress_level -- 0 to 9: lower is faster."""
    file = BytesIO()
    image.save(file, format="PNG", compress_level=compress_level)
    return file.getvalue()


@cache
def font(height: int) -> ImageFont.FreeTypeFont:
    """Return a font for lines of a height, pixels."""
    file = Path(mpl.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"
    size = height
    while sum(ImageFont.truetype(str(file), size).getmetrics()) > height:
        size -= 1
    return ImageFont.truetype(str(file), size)


class _Canvas:
    """Draws components one over the other."""

    def __init__(self, image: Image.Image, held: Part | None) -> None:
        self._image = image
        self._ink = ImageDraw.Draw(image)
        self._held = held
        self._kinds: Mapping[str, Callable[[Part], None]] = {
            "text": self._text,
            "button": self._button,
            "dual_state": self._switch,
            "number": self._number,
            "waveform": self._waveform,
        }

    def draw(self, part: Part) -> None:
        """Draw a component, if its kind has a picture."""
        if drawn := self._kinds.get(part.component.kind):
            drawn(part)

    # -- kinds ---------------------------------------------------------------------------------

    def _text(self, part: Part) -> None:
        self._ground(part, _colour(part, "bco", WHITE))
        self._write(part, str(part.values["txt"]), _colour(part, "pco", 0))

    def _button(self, part: Part) -> None:
        held = part is self._held
        suffix = "2" if held else ""
        self._ground(part, _colour(part, f"bco{suffix}", 1024 if held else 50_712))
        self._write(part, str(part.values["txt"]), _colour(part, f"pco{suffix}", 0))

    def _switch(self, part: Part) -> None:
        state = int(part.values["val"])
        self._ground(part, _colour(part, f"bco{state}", 1024 if state else 50_712))
        self._write(part, str(part.values["txt"]), _colour(part, "pco", 0))

    def _number(self, part: Part) -> None:
        self._ground(part, _colour(part, "bco", WHITE))
        digits = int(part.values.get("lenth", 0))  # minimum number of digits
        self._write(part, f"{int(part.values['val']):0{digits}d}", _colour(part, "pco", 0))

    def _waveform(self, part: Part) -> None:
        left, top, right, bottom = _box(part)
        self._ground(part, _colour(part, "bco", 0))
        grid = _colour(part, "gdc", 1024)
        for step, (start, end) in (("gdw", (left, right)), ("gdh", (bottom, top))):
            if pitch := int(part.values[step]):
                for at in range(start, end, pitch if end > start else -pitch):
                    line = (at, top, at, bottom) if step == "gdw" else (left, at, right, at)
                    self._ink.line(line, fill=grid)
        if part.waveform is not None:
            for points, name in zip(part.waveform.channels, CURVES, strict=False):
                self._curve(part, list(points), _colour(part, name, 64_495))

    def _curve(self, part: Part, points: list[int], colour: Colour) -> None:
        left, top, _, bottom = _box(part)
        places = [(left + at, max(top, bottom - value)) for at, value in enumerate(points)]
        if len(places) > 1:
            self._ink.line(places, fill=colour, width=2)
        elif places:
            self._ink.point(places, fill=colour)

    # -- shared --------------------------------------------------------------------------------

    def _ground(self, part: Part, colour: Colour) -> None:
        self._ink.rectangle(_box(part), fill=colour)

    def _write(self, part: Part, text: str, colour: Colour) -> None:
        """Write lines by the component's alignment: 0 left or top, 1 centre, 2 right or bottom."""
        height = FONTS[int(part.values.get("font", 0))]
        letters = font(height)
        place = part.component
        lines = text.split("\r\n")
        across, down = int(part.values.get("xcen", 1)), int(part.values.get("ycen", 1))
        mask = Image.new("L", (place.w, place.h))
        ink = ImageDraw.Draw(mask)
        y = _aligned(down, place.h - height * len(lines))
        for line in lines:
            ink.text(
                (_aligned(across, place.w - round(letters.getlength(line))), y), line, 255, letters
            )
            y += height
        self._image.paste(colour, (place.x, place.y), mask)


def _aligned(where: int, spare: int) -> int:
    return (0, spare // 2, spare)[where]


def _box(part: Part) -> Box:
    place = part.component
    return place.x, place.y, place.x + place.w - 1, place.y + place.h - 1


def _colour(part: Part, attribute: str, otherwise: int) -> Colour:
    return rgb(int(part.values.get(attribute, otherwise)))
