"""The pages with a keypad: they edit a segment, one number, or a name."""

from collections.abc import Callable, Iterable

from heatwright.spec.nextion.parts import GREEN, LARGE, RED, Page, Sheet
from heatwright.spec.nextion.programming import LONGEST_NUMBER
from heatwright.spec.programs import LONGEST_NAME

KINDS = ("time", "K/h", "fast", "until", "hold")
"""Names of the kinds of segment on the pages, in the order of their numbers in command 7."""

KEYS = ("7", "8", "9", "4", "5", "6", "1", "2", "3", ".", "0", "-")
LETTERS = ("abcdefghij", "klmnopqrst", "uvwxyz_-+/", "0123456789")
LONGEST_TITLE = 22

Change = Callable[[str], tuple[str, ...]]
"""Returns the code that applies `+="7"`, `-=1` or `=""` to the field which the keys edit."""


def point_page(number: int) -> Page:
    """Lay out the page that edits one segment: two fields, a keypad, the kinds of segment."""
    sheet = Sheet("point", number, "Entry of a segment.")
    sheet.number("n", (10, 5, 60, 50))
    sheet.text("k", (90, 5, 120, 50), 5, LARGE, shared=True)
    sheet.text("m", (10, 70, 230, 50), LONGEST_NUMBER, LARGE, release=("sel.val=0",), shared=True)
    sheet.text("t", (10, 150, 230, 50), LONGEST_NUMBER, LARGE, release=("sel.val=1",), shared=True)
    sheet.variable("sel")
    sheet.variable("kind")
    sheet.words("num", 4)
    for kind, text in enumerate(KINDS):
        chosen = (f"kind.val={kind}", f'k.txt="{text}"')
        sheet.button(f"k{kind}", (10 + 92 * kind, 420, 86, 55), text, chosen)
    _keypad(sheet, _into_selected)
    sheet.button("hours", (520, 342, 98, 62), "h", ('m.txt+="h"',))
    sheet.button("ok", (640, 330, 150, 60), "keep", (*_sent(), "page points"), GREEN)
    end = ('print "#7 "', "covx n.val,num.txt,0,0", "print num.txt", 'print ",0,0:;"')
    sheet.button("end", (640, 130, 150, 60), "end here", (*end, "page points"), RED)
    sheet.button("back", (640, 10, 150, 60), "back", ("page points",))
    sheet.label("lm", (246, 70, 60, 50), "h min")
    sheet.label("lt", (250, 150, 40, 50), "°C")
    return sheet.page(preinitialize=("sel.val=0", "kind.val=0", *_kind_by_name()))


def _kind_by_name() -> Iterable[str]:
    for kind, text in enumerate(KINDS[1:], 1):
        yield from (f'if(k.txt=="{text}")', "{", f"kind.val={kind}", "}")


def _sent() -> tuple[str, ...]:
    """Return code that sends command 7 with this segment; an empty field is sent as 0."""
    return (
        'if(m.txt=="")', "{", 'm.txt="0"', "}",
        'if(t.txt=="")', "{", 't.txt="0"', "}",
        'print "#7 "', "covx n.val,num.txt,0,0", "print num.txt",
        'print ","', "print m.txt", 'print ","', "print t.txt", 'print ","',
        "covx kind.val,num.txt,0,0", "print num.txt", 'print ":;"',
    )  # fmt: skip


def _into_selected(change: str) -> tuple[str, ...]:
    """Return code that changes the field that was touched last."""
    return (
        "if(sel.val==0)", "{", f"m.txt{change}", "}else", "{", f"t.txt{change}", "}",
    )  # fmt: skip


def number_page(number: int, backs: Iterable[tuple[int, str]]) -> Page:
    """Lay out the entry of a number for a command. backs -- number and name of each asking page."""
    sheet = Sheet("number", number, "Entry of a number.")
    sheet.text("what", (10, 10, 400, 50), LONGEST_TITLE, LARGE, shared=True)
    sheet.text("show", (10, 70, 230, 50), LONGEST_NUMBER, LARGE, shared=True)
    sheet.variable("cmd")
    sheet.variable("asker")
    sheet.words("num", 4)
    _keypad(sheet, _into_shown)
    leave = [f"if(asker.val=={id})|{{|page {name}|}}" for id, name in backs]  # noqa: A001
    code = tuple("|".join(leave).split("|"))
    order = ("covx cmd.val,num.txt,0,0", 'print "#"', "print num.txt", 'print " "')
    value = ("print show.txt", 'print ";"')
    sheet.button("ok", (640, 330, 150, 60), "set", (*order, *value, *code), GREEN)
    sheet.button("back", (640, 10, 150, 60), "back", code)
    return sheet.page()


def asking(command: int, title: str, field: str, asker: int) -> tuple[str, ...]:
    """Return the code that opens the entry of a number, preset with the text of a field."""
    return (
        f"number.cmd.val={command}",
        f"number.asker.val={asker}",
        f'number.what.txt="{title}"',
        f"number.show.txt={field}.txt",
        "page number",
    )


def name_page(number: int) -> Page:
    """Lay out the entry of a program's name."""
    sheet = Sheet("name", number, "Entry of a program's name.")
    sheet.text("show", (10, 10, 400, 50), LONGEST_NAME, LARGE, shared=True)
    for row, letters in enumerate(LETTERS):
        for column, letter in enumerate(letters):
            place = (10 + 78 * column, 80 + 70 * row, 72, 64)
            sheet.button(f"c{row}{column}", place, letter, _into_shown(f'+="{letter}"'))
    sheet.button("space", (10, 370, 300, 64), "space", _into_shown('+=" "'))
    sheet.button("less", (322, 370, 150, 64), "<", _into_shown("-=1"))
    kept = ('print "#14 "', "print show.txt", 'print ";"', "page points")
    sheet.button("ok", (640, 370, 150, 64), "keep", kept, GREEN)
    sheet.button("back", (640, 10, 150, 60), "back", ("page points",))
    return sheet.page()


def _into_shown(change: str) -> tuple[str, ...]:
    return (f"show.txt{change}",)


def _keypad(sheet: Sheet, change: Change) -> None:
    """Add keys for digits, point and sign; `<` deletes the last character, C all."""
    for place, key in enumerate(KEYS):
        column, row = place % 3, place // 3
        x, y = 310 + 105 * column, 70 + 68 * row
        sheet.button(f"d{place}", (x, y, 98, 62), key, change(f'+="{key}"'))
    sheet.button("less", (310, 342, 98, 62), "<", change("-=1"))
    sheet.button("clear", (415, 342, 98, 62), "C", change('=""'))
