"""A Nextion display without its line: it receives instructions and touches, and sends bytes."""

from collections.abc import Sequence

from heatwright.sim.interfaces.nextion import events
from heatwright.sim.interfaces.nextion.codes import END, READY, STARTED, Code, Refused
from heatwright.sim.interfaces.nextion.instructions import Instructions
from heatwright.sim.interfaces.nextion.memory import Memory, Part
from heatwright.sim.interfaces.nextion.syntax import Name, Value
from heatwright.spec.nextion import Page

BUFFER_BYTES = 1024
"""Size of the receive buffer; bytes that do not fit are lost, and reported as an error."""
DEEPEST = 10
"""Maximum depth of a touch's nested events: pages that show each other would never end."""
TOUCHED = ("button", "dual_state")
"""Kinds of component that take a touch even without code."""
PAGE_EVENTS = ("preinitialize", "postinitialize")
PART_EVENTS = ("press", "release", "timer")


class Display:
    """The display.

    out -- bytes it has sent, until they are taken; errors -- refused instructions from the line,
    with the reason; memory -- its components; held -- the component under the finger; is_on --
    whether it has power and has started.
    """

    def __init__(self, pages: Sequence[Page]) -> None:
        self._pages = tuple(pages)
        self._code = {
            (page.name, "", event): events.read(getattr(page, event))
            for page in self._pages
            for event in PAGE_EVENTS
        } | {
            (page.name, part.name, event): events.read(getattr(part, event))
            for page in self._pages
            for part in page.components
            for event in PART_EVENTS
        }
        self.memory = Memory(pages)
        self._depth = 0
        self._waiting = bytearray()
        self._since_ms: dict[str, float] = {}
        self._instructions = Instructions(self.memory, self._send, self.show, self._event)
        self.errors: list[tuple[str, Code]] = []
        self.is_on = self._midway = False
        self.out = bytearray()
        self.held: Part | None = None

    def start(self, *, midway: bool = False) -> None:
        """Switch the power on: the display shows its first page.

        midway -- whether an instruction was under way: its rest is ignored, without an error.
        """
        self.is_on, self._midway = True, midway
        self.out.clear()
        self.held = None
        self._waiting.clear()
        self._depth = 0
        self.memory.start()
        self._send(STARTED)
        self.show(0)
        self._send(READY)

    @property
    def page(self) -> str:
        """The name of the shown page."""
        return self._pages[self.memory.page].name

    @property
    def ground(self) -> int:
        """The background colour of the shown page."""
        return int(self.memory.parts[self.memory.page][self.page].values["bco"])

    def value(self, attribute: str) -> Value:
        """Return an attribute's present value: b0.txt of the shown page, or main.b0.txt.

        Raises Refused: there is no such attribute.
        """
        return self.memory.get(Name(tuple(attribute.split("."))))

    def take(self) -> bytes:
        """Return the bytes it has sent since the last call."""
        sent = bytes(self.out)
        self.out.clear()
        return sent

    # -- the line ------------------------------------------------------------------------------

    def receive(self, data: bytes) -> list[str]:
        """Receive bytes from the line; return the instructions that they complete."""
        *ended, rest = (self._waiting + data).split(END)
        self._waiting = bytearray(rest)
        if len(rest) > BUFFER_BYTES:
            self._waiting.clear()
            self._refuse(f"{len(rest)} bytes", Code.BUFFER_OVERFLOW)
        done = [each.decode("latin-1") for each in ended]
        for instruction in done:
            self._follow(instruction)
            self._midway = False
        return done

    def _follow(self, instruction: str) -> None:
        try:
            self._instructions.do(instruction)
        except Refused as refused:
            self._refuse(instruction, refused.code)
        else:
            if self.memory.variables["bkcmd"] in {1, 3}:
                self._send(Code.DONE.answer())

    def _refuse(self, instruction: str, code: Code) -> None:
        if not self._midway:
            self.errors.append((instruction, code))
        if code is Code.BUFFER_OVERFLOW or self.memory.variables["bkcmd"] in {2, 3}:
            self._send(code.answer())

    def _send(self, data: bytes) -> None:
        self.out += data

    # -- pages and touches ---------------------------------------------------------------------

    def show(self, page: int) -> None:
        """Show a page by its number, and run its start code."""
        self.held = None
        self._since_ms.clear()
        self.memory.show(page)
        name = self._pages[page].name
        for event in PAGE_EVENTS:
            if self._run(name, "", event):
                return

    def press(self, name: str) -> None:
        """Touch a component of the shown page, by its name.

        Raises LookupError: it is not there, is hidden, or takes no touch.
        """
        part = self.memory.parts[self.memory.page].get(name) if self.is_on else None
        if part is None or not part.visible or not part.touchable or not self._takes_touch(part):
            raise LookupError(f"{name} on page {self.page} takes no touch, or is hidden.")
        place = part.component
        x, y = place.x + place.w // 2, place.y + place.h // 2
        if self.at(x, y) is not part:
            raise LookupError(f"Another component covers {name} on page {self.page}.")
        self.touch(x, y)

    def touch(self, x: int, y: int) -> None:
        """Touch a point."""
        part = self.at(x, y)
        if part is None or not part.touchable:
            return
        self.held = part
        if part.component.kind == "dual_state":
            part.values["val"] = 1 - int(part.values["val"])
        self._event(part, "press")

    def release(self) -> None:
        """Release the touch."""
        part, self.held = self.held, None
        if part is not None:
            self._event(part, "release")

    def at(self, x: int, y: int) -> Part | None:
        """Return the foremost component at a point, of those that take touches."""
        for part in reversed(tuple(self.memory.shown())):
            place = part.component
            inside = 0 <= x - place.x < place.w and 0 <= y - place.y < place.h
            if inside and part.visible and self._takes_touch(part):
                return part
        return None

    def _takes_touch(self, part: Part) -> bool:
        place = part.component
        return place.kind in TOUCHED or bool(place.press or place.release)

    # -- time ----------------------------------------------------------------------------------

    def pass_time(self, milliseconds: float) -> None:
        """Let the page's timers run for a time."""
        for part in self.memory.timers:
            if part.values["en"]:
                name = part.component.name
                self._since_ms[name] = self._since_ms.get(name, 0.0) + milliseconds
                while self._since_ms.get(name, 0.0) >= int(part.values["tim"]):
                    self._since_ms[name] -= int(part.values["tim"])
                    self._event(part, "timer")

    # -- events --------------------------------------------------------------------------------

    def _event(self, part: Part, event: str) -> None:
        self._run(self.page, part.component.name, event)

    def _run(self, page: str, owner: str, event: str) -> bool:
        """Run an event; return whether the page has changed. Raises PageError."""
        code = self._code[page, owner, event]
        if self._depth == DEEPEST:
            raise events.PageError(f"The events of {page} never end.")
        self._depth += 1
        try:
            return events.run(code, self._instructions.do, self._instructions.holds)
        except Refused as refused:
            place = ".".join(filter(None, (page, owner, event)))
            raise events.PageError(f"{place}: {refused}.") from refused
        finally:
            self._depth -= 1
