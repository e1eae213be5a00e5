"""The memory of a Nextion display: its pages' components with their attributes, and variables.

The memory has the components of the shown page, and all with vscope `global`. A local component
starts again whenever its page is shown, and other pages cannot access it (Nextion Editor guide).
"""

from collections import deque
from collections.abc import Iterator, Sequence

from heatwright.sim.interfaces.nextion.codes import Code, Refused
from heatwright.sim.interfaces.nextion.syntax import Expression, Name, Value, whole
from heatwright.spec.nextion import Component, Page

BAUDS = (2400, 4800, 9600, 19200, 31250, 38400, 57600, 115_200, 230_400, 250_000, 256_000, 512_000,
         921_600)  # fmt: skip
"""Baud rates of its line (Nextion Instruction Set, section 6, `baud`)."""
VARIABLES = {"bkcmd": 2, "dim": 100, "dp": 0, "sys0": 0, "sys1": 0, "sys2": 0}
"""The display's own variables that are simulated, and their values at power-up."""
BOUNDS = {"bkcmd": (0, 3), "dim": (0, 100)}

DEFAULTS: dict[str, dict[str, Value]] = {
    "text": {"txt": "", "txt_maxl": 10},
    "button": {"txt": "", "txt_maxl": 10},
    "dual_state": {"txt": "", "txt_maxl": 10, "val": 0},
    "number": {"val": 0},
    "variable": {},
    "page": {},
    "timer": {"tim": 400, "en": 1},
    "waveform": {"ch": 1, "gdc": 1024, "gdw": 40, "gdh": 40},
}
"""The attributes of each kind of component, with the editor's default values."""
FIXED = {"id", "x", "y", "w", "h", "txt_maxl", "ch", "font_name"}
"""Attributes that only the editor can set."""
ALL_CHANNELS = 255
"""The channel number that means all channels in `cle`."""


class Waveform:
    """The points of a waveform component while its page is shown.

    channels -- the newest points of each, oldest first, as many as the component is wide.
    """

    def __init__(self, width: int, channels: int) -> None:
        self.channels: tuple[deque[int], ...] = tuple(deque(maxlen=width) for _ in range(channels))

    def add(self, channel: int, value: int) -> None:
        """Add a point, 0 to 255; other values are refused (the display's manual forbids them)."""
        if not 0 <= value <= 255:
            raise Refused(Code.INVALID_OPERATION)
        self._channel(channel).append(value)

    def clear(self, channel: int) -> None:
        """Delete all points of a channel, or of all channels."""
        for each in self.channels if channel == ALL_CHANNELS else (self._channel(channel),):
            each.clear()

    def _channel(self, channel: int) -> deque[int]:
        if not 0 <= channel < len(self.channels):
            raise Refused(Code.INVALID_WAVEFORM)
        return self.channels[channel]


class Part:
    """A component in memory. values -- its attributes; visible, touchable -- see vis and tsw."""

    def __init__(self, component: Component) -> None:
        self.component = component
        self.start()

    def start(self) -> None:
        """Set every attribute to its value in the editor."""
        component = self.component
        self.values: dict[str, Value] = {
            **DEFAULTS[component.kind],
            **component.attributes,
            "id": component.id,
            "x": component.x,
            "y": component.y,
            "w": component.w,
            "h": component.h,
        }
        self.show()

    def show(self) -> None:
        """Begin to be shown: a waveform is cleared, and a hidden component is visible again."""
        self.visible = self.touchable = True
        self.waveform: Waveform | None = None
        if self.component.kind == "waveform":
            self.waveform = Waveform(self.component.w, int(self.values["ch"]))

    def get(self, attribute: str) -> Value:
        """Return an attribute."""
        if attribute not in self.values:
            raise Refused(Code.INVALID_VARIABLE)
        return self.values[attribute]

    def set(self, attribute: str, value: Value) -> None:
        """Set an attribute: to a number if it is one, or to a text, cut to its longest length."""
        held = self.get(attribute)
        if attribute in FIXED or type(held) is not type(value):
            raise Refused(Code.INVALID_OPERATION)
        if isinstance(value, str):
            value = value[: int(self.values.get("txt_maxl", len(value)))]
        self.values[attribute] = value


class Memory:
    """The display's memory; page -- the number of the shown page; timers -- those of that page."""

    def __init__(self, pages: Sequence[Page]) -> None:
        self._pages = tuple(pages)
        self._numbers = {page.name: number for number, page in enumerate(self._pages)}
        self.kept_baud = BAUDS[2]
        """The baud rate at start-up; 9600 in a new display."""
        self.timers: tuple[Part, ...] = ()
        self.start()

    def start(self) -> None:
        """Start again, as at power-up; no page is shown yet."""
        self.variables = VARIABLES | {"baud": self.kept_baud, "bauds": self.kept_baud}
        self.parts: tuple[dict[str, Part], ...] = tuple(
            {component.name: Part(component) for component in _from_back(page)}
            for page in self._pages
        )
        self.page = 0

    def show(self, page: int) -> None:
        """Load the components of another page, or the same page's again."""
        self.page = self.variables["dp"] = page
        parts = self.parts[page].values()
        self.timers = tuple(part for part in parts if part.component.kind == "timer")
        for part in parts:
            if part.component.shared:
                part.show()
            else:
                part.start()

    def page_number(self, which: Value | Name) -> int:
        """Find a page by its name or number."""
        if isinstance(which, Name) and len(which.parts) == 1 and which.parts[0] in self._numbers:
            return self._numbers[which.parts[0]]
        if isinstance(which, int) and 0 <= which < len(self._pages):
            return which
        raise Refused(Code.INVALID_PAGE)

    def shown(self) -> Iterator[Part]:
        """Yield the components of the shown page, from the back to the front."""
        yield from self.parts[self.page].values()

    def part(self, which: Value | Name) -> Part:
        """Find a component of the shown page, by its name or number."""
        for part in self.parts[self.page].values():
            by_name = isinstance(which, Name) and which.parts == (part.component.name,)
            if by_name or which == part.component.id:
                return part
        raise Refused(Code.INVALID_COMPONENT)

    # -- attributes ----------------------------------------------------------------------------

    def get(self, name: Name) -> Value:
        """Return an attribute or a variable."""
        if len(name.parts) > 1:
            return self._owner(name).get(name.parts[-1])
        if name.parts[0] not in self.variables:
            raise Refused(Code.INVALID_VARIABLE)
        return self.variables[name.parts[0]]

    def set(self, name: Name, value: Value) -> None:
        """Set an attribute or a variable."""
        if len(name.parts) > 1:
            self._owner(name).set(name.parts[-1], value)
            return
        self.get(name)
        variable = name.parts[0]
        if variable in {"baud", "bauds"}:
            self._set_baud(variable, value)
            return
        low, high = BOUNDS.get(variable, (-(2**31), 2**31))
        if variable == "dp" or not isinstance(value, int) or not low <= value <= high:
            raise Refused(Code.INVALID_OPERATION)
        self.variables[variable] = value

    def _set_baud(self, variable: str, value: Value) -> None:
        """Change the baud rate at once; `bauds` also changes it for later power-ups."""
        if not isinstance(value, int) or value not in BAUDS:
            raise Refused(Code.INVALID_BAUD)
        self.variables["baud"] = value
        if variable == "bauds":
            self.variables["bauds"] = self.kept_baud = value

    def value(self, given: Value | Name) -> Value:
        """Return the value of an operand."""
        return self.get(given) if isinstance(given, Name) else given

    def evaluate(self, asked: Expression) -> Value:
        """Return an expression's value: a 32-bit integer, or a concatenation of texts."""
        value = self.value(asked.first)
        for operator, operand in asked.rest:
            value = _joined(operator, value, self.value(operand))
        return value

    def _owner(self, name: Name) -> Part:
        """Find the component of PAGE.COMPONENT.ATTRIBUTE or COMPONENT.ATTRIBUTE."""
        *page, component, _ = name.parts
        if len(page) > 1 or (page and page[0] not in self._numbers):
            raise Refused(Code.INVALID_VARIABLE)
        number = self._numbers[page[0]] if page else self.page
        part = self.parts[number].get(component)
        if part is None or (number != self.page and not part.component.shared):
            raise Refused(Code.INVALID_VARIABLE)
        return part


def _from_back(page: Page) -> list[Component]:
    """List a page's components by their numbers: 0 is the page itself, behind all others."""
    ground = Component("page", page.name, 0, attributes={"bco": page.bco})
    return sorted((ground, *page.components), key=lambda component: component.id)


def _joined(operator: str, left: Value, right: Value) -> Value:
    if isinstance(left, str):
        if operator == "+" and isinstance(right, str):
            return left + right
        if operator == "-" and isinstance(right, int) and right >= 0:
            return left[: max(0, len(left) - right)]
        raise Refused(Code.INVALID_OPERATION)
    if isinstance(right, str) or (operator in "/%" and right == 0):
        raise Refused(Code.INVALID_OPERATION)
    return whole(_computed(operator, left, right))


def _computed(operator: str, left: int, right: int) -> int:
    if operator == "+":
        return left + right
    if operator == "-":
        return left - right
    if operator == "*":
        return left * right
    quotient = abs(left) // abs(right) * (1 if left * right >= 0 else -1)
    return quotient if operator == "/" else left - right * quotient
