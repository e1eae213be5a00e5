"""The menu at the keypad of a loop with programs."""

STATE, TIMES, RUN, EDIT, VALUES = range(5)
"""The screens, in the order in which RIGHT shows them."""
SCREENS = 5


class MenuKeys:
    """The present screen of the menu.

    The model knows only one function of the screens: the setpoint, which is the first of the
    values. Programs are started and ended by commands, not by keys.
    """

    def __init__(self) -> None:
        """Start at the screen with the state."""
        self._screen = STATE
        self._is_first = True

    def moves(self, key: str | None) -> int:
        """Process a key press; return by how many key steps it changes the setpoint."""
        if key in {"left", "right"}:
            self._screen = (self._screen + (1 if key == "right" else -1)) % SCREENS
            self._is_first = True
        elif key == "select":
            self._is_first = False
        elif self._screen == VALUES and self._is_first:
            return {"up": 1, "down": -1}.get(key or "", 0)
        return 0
