"""The touch display: its page as a picture, and touches of its components."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from heatwright.cli.bench.parts.seat import BadOrder, Live, Order, Seat, flag_of, number_of, text_of
from heatwright.cli.bench.world import LiveWorld
from heatwright.sim.interfaces.nextion import Nextion
from heatwright.sim.interfaces.nextion.screen import draw
from heatwright.spec import Controller
from heatwright.spec.nextion import HEIGHT, WIDTH

if TYPE_CHECKING:
    from PIL.Image import Image


class TouchDisplay(Seat):
    """A person at the touch display."""

    kind = "nextion"

    def __init__(self, controller: Controller, number: int) -> None:
        super().__init__(controller, number)
        self._drawn: tuple[Any, ...] = ()

    def about(self) -> dict[str, Any]:
        """Return the size of a page, pixels."""
        return {"width": WIDTH, "height": HEIGHT}

    def state(self, world: LiveWorld) -> dict[str, Any]:
        """Return the current page, the components that can be touched, and the texts."""
        display = self.part(world)
        del display.errors[:-1]
        display.history.clear()
        if not display.display.is_on:
            return {"page": None, "touchable": [], "texts": []}
        shown = display.display.memory.parts[display.display.memory.page].values()
        return {
            "page": display.page,
            "touchable": list(self._touchable(display)),
            "texts": [
                text
                for each in shown
                if each.visible and (text := _text(each)) and each.component.kind != "button"
            ],
        }

    def picture(self, world: LiveWorld) -> Image | None:
        """Draw the page, if anything on it has changed."""
        display = self.part(world)
        memory = display.display.memory
        held = display.display.held
        drawn = (
            display.display.is_on,
            memory.page,
            held.component.name if held else None,
            tuple((each.visible, *each.values.values()) for each in memory.shown()),
            display.instructions if any(each.waveform for each in memory.shown()) else 0,
        )
        if drawn == self._drawn:
            return None
        self._drawn = drawn
        return draw(display.display)

    def act(self, live: Live, order: Order) -> None:
        """Touch a component or a place, or release the touch, wherever the finger is now."""
        display = self.part(live.world)
        display.said.clear()
        if flag_of(order, "down") and "x" in order:
            x, y = number_of(order, "x", 0, WIDTH - 1), number_of(order, "y", 0, HEIGHT - 1)
            display.touch(int(x), int(y))
        elif flag_of(order, "down"):
            try:
                display.press(text_of(order, "name", 40))
            except LookupError as error:
                raise BadOrder(str(error)) from None
        else:
            display.release()
        for said in display.said:
            for command in said.split(b";")[:-1]:
                if command.startswith(b"#"):
                    live.record({"send": f"{command.decode('latin-1')};"})

    @staticmethod
    def _touchable(display: Nextion) -> Iterator[dict[str, Any]]:
        for part in display.display.memory.shown():
            place = part.component
            middle = place.x + place.w // 2, place.y + place.h // 2
            if part.visible and part.touchable and display.display.at(*middle) is part:
                yield {
                    "name": place.name,
                    "text": _text(part) or place.name,
                    "x": place.x,
                    "y": place.y,
                    "w": place.w,
                    "h": place.h,
                }


def _text(part: Any) -> str:
    text = str(part.values.get("txt", part.values.get("val", "")))
    return " ".join(text.split()) if part.component.kind != "variable" else ""


take = TouchDisplay
