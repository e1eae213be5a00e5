"""The simulated display follows instructions and touches as its manual has it, and draws them."""

from collections.abc import Mapping
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from PIL import Image

from heatwright.sim.interfaces.nextion.codes import Code
from heatwright.sim.interfaces.nextion.display import BUFFER_BYTES, Display
from heatwright.sim.interfaces.nextion.events import PageError
from heatwright.sim.interfaces.nextion.screen import draw, png, rgb
from heatwright.spec.nextion import Component, Page

FIRST = (
    Component("text", "t0", 1, 20, 20, 200, 60, {"txt": "", "txt_maxl": 10, "font": 1}),
    Component("number", "n0", 2, 600, 300, 100, 40, {"val": 0, "font": 0}, shared=True),
    Component("number", "n1", 3, 600, 350, 100, 40, {"val": 4, "font": 0}),
    Component("dual_state", "bt1", 4, 600, 400, 100, 40, {"txt": "on", "txt_maxl": 3, "font": 0},
              release=("if(bt1.val==1)", "{", 'print "#9 1;"', "}else", "{", 'print "#9 0;"', "}")),
    Component("button", "b0", 5, 600, 120, 160, 70, {"txt": "go", "txt_maxl": 3, "font": 0},
              press=("n1.val+=2",), release=("covx n1.val,t0.txt,3,0", "print t0.txt")),
    Component("button", "b1", 6, 600, 200, 160, 70, {"txt": "away", "txt_maxl": 5, "font": 0},
              release=("page away", "n0.val=99")),
    Component("waveform", "s0", 7, 20, 120, 40, 100, {"ch": 2, "gdw": 20, "gdh": 20}),
    Component("timer", "tm0", 8, attributes={"tim": 100, "en": 0}, timer=("n1.val++",)),
    Component("variable", "va0", 9, attributes={"sta": 1, "txt": "", "txt_maxl": 4}, shared=True),
)  # fmt: skip
SECOND = (
    Component("text", "t0", 1, 0, 0, 800, 480, {"txt": "away", "txt_maxl": 10, "font": 1}),
    Component("number", "n0", 2, attributes={"val": 7}),
)
PAGES = (
    Page("first", 0, FIRST, postinitialize=('print "#21 0;"',)),
    Page("away", 1, SECOND, ("n0.val+=1",), ('print "#21 1;"',)),
)
STARTED = b"\0\0\0\xff\xff\xff#21 0;\x88\xff\xff\xff"


def display(*pages: Page) -> Display:
    made = Display(pages or PAGES)
    made.start()
    made.take()
    return made


def page_of(*components: Component, **events: Any) -> Page:
    return Page("only", 0, components, **events)


def tell(shown: Display, *instructions: str) -> bytes:
    for each in instructions:
        shown.receive(each.encode("latin-1") + b"\xff\xff\xff")
    return shown.take()


def button(name: str, *release: str, attributes: Mapping[str, int | str] | None = None,
           place: tuple[int, int] = (0, 0)) -> Component:  # fmt: skip
    own = {"txt": name, "txt_maxl": 14, "font": 0, **(attributes or {})}
    return Component("button", name, 1, *place, 100, 50, own, release=release)


# -- instructions, done and refused

REFUSED = {
    Code.INVALID_INSTRUCTION: ("foo", "", "if(n0.val==1)", "Page first", "n0.val=1+"),
    Code.INVALID_COMPONENT: ("vis b9,0", "vis 99,0", "click gone,1"),
    Code.INVALID_PAGE: ("page gone", "page 2", "page -1"),
    Code.INVALID_BAUD: ("baud=9601", "bauds=1200", 'baud="9600"'),
    Code.INVALID_WAVEFORM: ("add 1,0,3", "add 99,0,3", "add 7,2,3", "cle 7,2", "cle 1,0"),
    Code.INVALID_VARIABLE: (
        "n0.val=1 2", "n9.val=1", "n0.txt=1", "q=1", "gone.n0.val=1", "away.n0.val=1",
        "first.n0.val.x=1", "get b"),
    Code.INVALID_OPERATION: (
        "add 7,0,256", 'n0.val="a"', "t0.txt=5", 't0.txt="a"*2', "n0.val=1/0", "n0.x=5", "dim=101",
        "dp=1", "bkcmd=4"),
    Code.INVALID_QUANTITY: ("page", "add 7,0", "vis t0", "sendme 1"),
    Code.INVALID_ESCAPE: ('t0.txt="a\\qb"',),
    Code.NAME_TOO_LONG: ("abcdefghijklmno.val=1",),
}  # fmt: skip


@pytest.mark.parametrize(
    ("instruction", "code"), [(each, code) for code in REFUSED for each in REFUSED[code]]
)
def test_it_refuses(instruction: str, code: Code) -> None:
    shown = display()
    before = [dict(part.values) for part in shown.memory.shown()]
    assert tell(shown, instruction) == bytes([code]) + b"\xff\xff\xff"
    assert shown.errors == [(instruction, code)]
    assert [part.values for part in shown.memory.shown()] == before


def test_what_it_answers_is_chosen() -> None:
    """Bkcmd: nothing, good news, bad news (the choice at power-up), both."""
    good, bad = b"\x01\xff\xff\xff", b"\x1a\xff\xff\xff"
    for chosen, answers in enumerate(((b"", b""), (good, b""), (b"", bad), (good, bad))):
        shown = display()
        tell(shown, f"bkcmd={chosen}")
        assert (tell(shown, "n0.val=3"), tell(shown, "n9.val=3")) == answers


@pytest.mark.parametrize(
    ("instruction", "attribute", "value"),
    [
        ("n0.val=5", "n0.val", 5), ("first.n0.val=-5", "first.n0.val", -5),
        ("n0.val=0x10", "n0.val", 16), ("n0.val=2147483647+1", "n0.val", -(2**31)),
        ("n1.val+=3", "n1.val", 7), ("n1.val-=5", "n1.val", -1), ("n1.val*=-2", "n1.val", -8),
        ("n1.val=n1.val/3", "n1.val", 1), ("n1.val=-7%n1.val", "n1.val", -3),
        ("n1.val++", "n1.val", 5), ("n1.val--", "n1.val", 3),
        ("n0.val=2+3*2-1", "n0.val", 9),  # from left to right
        ('t0.txt="12 °C"', "t0.txt", "12 °C"), ('t0.txt="longer than ten"', "t0.txt", "longer tha"),
        ('t0.txt="a"+"b"', "t0.txt", "ab"), ('t0.txt="abcd"-2', "t0.txt", "ab"),
        ('t0.txt="a\\"b\\\\"', "t0.txt", 'a"b\\'), ('t0.txt="a=b,c"', "t0.txt", "a=b,c"),
        ("covx n1.val,t0.txt,0,0", "t0.txt", "4"), ("covx n1.val,t0.txt,3,0", "t0.txt", "004"),
        ('covx "-12x",n0.val,0,0', "n0.val", -12), ('covx "ff",n0.val,0,2', "n0.val", 255),
        ("covx 1234567,t0.txt,0,1", "t0.txt", "1,234,567"), ("covx 123,t0.txt,2,0", "t0.txt", "23"),
        ("tm0.en=1", "tm0.en", 1), ("dim=50", "dim", 50), ("sys0=3", "sys0", 3)],
)  # fmt: skip
def test_it_assigns(instruction: str, attribute: str, value: int | str) -> None:
    shown = display()
    assert tell(shown, instruction) == b""
    assert shown.value(attribute) == value


def test_it_tells_what_it_holds() -> None:
    shown = display()
    tell(shown, "n0.val=-2", 't0.txt="a°"')
    for instruction, answer in (
        ("get n0.val", b"\x71\xfe\xff\xff\xff\xff\xff\xff"),
        ("get t0.txt", b"\x70a\xb0\xff\xff\xff"),
        ("print t0.txt", b"a\xb0"), ("print n0.val", b"\xfe\xff\xff\xff"),
        ("printh 23 0d", b"\x23\x0d"), ("sendme", b"\x66\0\xff\xff\xff"),
        ("page away", b"#21 1;"), ("sendme", b"\x66\1\xff\xff\xff"),
    ):  # fmt: skip
        assert tell(shown, instruction) == answer


def test_instructions_come_in_any_pieces() -> None:
    shown = display()
    data = b'n0.val=3\xff\xff\xfft0.txt="\xfe"\xff\xff\xff'
    done = [text for at in range(len(data)) for text in shown.receive(data[at : at + 1])]
    assert done == ["n0.val=3", 't0.txt="\xfe"']
    assert shown.value("n0.val") == 3


def test_a_line_without_end_overflows() -> None:
    shown = display()
    tell(shown, "bkcmd=0")
    shown.receive(b"x" * (BUFFER_BYTES + 1))
    assert shown.take() == bytes([Code.BUFFER_OVERFLOW]) + b"\xff\xff\xff"
    assert tell(shown, "n0.val=3") == b""
    assert shown.value("n0.val") == 3


def test_it_says_that_it_has_started() -> None:
    """And it begins anew with everything."""
    shown = Display(PAGES)
    shown.start()
    assert shown.take() == STARTED
    tell(shown, "n0.val=3", "page away", "bkcmd=0")
    shown.start()
    assert shown.take() == STARTED
    assert (shown.page, shown.value("n0.val"), shown.value("bkcmd")) == ("first", 0, 2)


def test_a_speed_of_its_line_is_kept_where_it_is_told_so() -> None:
    shown = display()
    for instruction, now, later in (("baud=19200", 19_200, 9600), ("bauds=57600", 57_600, 57_600)):
        tell(shown, instruction)
        assert shown.value("baud") == now
        shown.start()
        assert shown.value("baud") == later


def test_only_what_is_global_is_reached_from_elsewhere() -> None:
    shown = display()
    tell(shown, "n1.val=9", "page away", "first.n0.val=3", "first.n1.val=3")
    assert shown.errors == [("first.n1.val=3", Code.INVALID_VARIABLE)]
    tell(shown, "page first")
    assert (shown.value("n0.val"), shown.value("n1.val")) == (3, 4)


def test_waveforms() -> None:
    """As many points as it is wide; it belongs to its page."""
    shown = display()

    def points() -> list[list[int]]:
        waveform = shown.memory.parts[0]["s0"].waveform
        assert waveform is not None
        return [list(each) for each in waveform.channels]

    tell(shown, *(f"add 7,0,{value}" for value in range(60)), "add s0.id,1,5")
    assert points() == [list(range(20, 60)), [5]]
    for instruction, left in (("cle 7,0", [[], [5]]), ("cle 7,255", [[], []])):
        tell(shown, instruction)
        assert points() == left
    tell(shown, "add 7,0,3", "page away", "add 7,0,3")
    assert shown.errors == [("add 7,0,3", Code.INVALID_WAVEFORM)]
    tell(shown, "page first")
    assert points() == [[], []]


# -- touches, events and timers


def tap(shown: Display, name: str) -> bytes:
    shown.press(name)
    shown.release()
    return shown.take()


def test_a_button_runs_its_code() -> None:
    shown = display()
    shown.press("b0")
    assert shown.held is not None
    assert shown.value("n1.val") == 6
    shown.release()
    assert (shown.value("t0.txt"), shown.take()) == ("006", b"006")
    shown.release()
    assert shown.take() == b""
    assert tell(display(), "click b0,1", "click b0,0") == b"006"


def test_the_rest_of_an_instruction_that_began_before_it_started_is_no_error() -> None:
    shown = Display(PAGES)
    shown.start(midway=True)
    tell(shown, "6", "6")
    assert shown.errors == [("6", Code.INVALID_INSTRUCTION)]


def test_a_button_of_two_states() -> None:
    shown = display()
    for state in (1, 0):
        assert tap(shown, "bt1") == b"#9 %d;" % state
        assert shown.value("bt1.val") == state


def test_a_page_begins_with_its_code_and_nothing_follows() -> None:
    """What stands behind `page` is never run: its page is gone."""
    shown = display()
    assert tap(shown, "b1") == b"#21 1;"
    assert (shown.page, shown.value("n0.val"), shown.value("first.n0.val")) == ("away", 8, 0)


@pytest.mark.parametrize("name", ["t0", "s0", "gone", "tm0"])
def test_nobody_presses_what_is_no_button(name: str) -> None:
    """Nor anything without power."""
    with pytest.raises(LookupError, match=name):
        display().press(name)
    with pytest.raises(LookupError):
        Display(PAGES).press("b0")


def test_nobody_presses_what_is_hidden_or_switched_off() -> None:
    shown = display()
    for away, back in (("vis b0,0", "vis b0,1"), ("tsw b0,0", "tsw 255,1")):
        tell(shown, away)
        with pytest.raises(LookupError):
            shown.press("b0")
        tell(shown, back)
        assert tap(shown, "b0")
    tell(shown, "vis 255,0", "page away", "page first")
    shown.press("b0")


def test_nobody_presses_what_is_covered() -> None:
    under = button("under", 'print "u"')
    over = Component("button", "over", 2, 20, 10, 100, 50, {"txt": ""}, release=('print "o"',))
    shown = display(page_of(under, over))
    with pytest.raises(LookupError, match="component covers under"):
        shown.press("under")
    for place in ((5, 5), (60, 30), (700, 400)):
        shown.touch(*place)
        shown.release()
    assert shown.take() == b"uo"


def test_timers_run_while_their_page_is_shown() -> None:
    shown = display()
    shown.pass_time(1000)
    tell(shown, "tm0.en=1")
    shown.pass_time(99)
    assert shown.value("n1.val") == 4
    shown.pass_time(251)
    assert shown.value("n1.val") == 7
    tell(shown, "page away")
    shown.pass_time(1000)
    tell(shown, "page first")
    assert shown.value("n1.val") == 4


def tapped(code: tuple[str, ...], *parts: Component) -> bytes:
    return tap(display(page_of(button("b0", *code), *parts)), "b0")


@pytest.mark.parametrize(
    ("value", "said"), [(0, b"small"), (5, b"five"), (7, b"large"), (9, b"nine")]
)
def test_choices(value: int, said: bytes) -> None:
    code = (
        "if(n0.val<5)", "{", 'print "small"', "}else if(n0.val==5)", "{", 'print "five"', "}",
        "else", "{", 'if(n0.val>=9&&t0.txt=="a")', "{", 'print "nine"', "} else {",
        'print "large" ', "}", "}",
    )  # fmt: skip
    number = Component("number", "n0", 2, attributes={"val": value})
    assert tapped(code, number, Component("text", "t0", 3, attributes={"txt": "a"})) == said


TRUE = ("1==1", "2<=2", "3>2", "-1<0", '"a"=="a"', "1==2||3==3", '"<"=="<"', "1 == 1")
FALSE = ("1!=1", '"a"!="a"', "1==1&&2==3")


@pytest.mark.parametrize("condition", TRUE + FALSE)
def test_conditions(condition: str) -> None:
    code = (f"if({condition})", "{", 'print "x"', "}")
    assert tapped(code) == b"x" * (condition in TRUE)


@pytest.mark.parametrize(
    "code", ["if(1==1)|{", "}", "else|{|}", "if 1==1|{|}", "if(1==1)|page 0", "{|}"]
)
def test_code_the_editor_would_refuse(code: str) -> None:
    with pytest.raises(PageError):
        display(page_of(button("b0", *code.split("|"))))


@pytest.mark.parametrize(
    "line", ["n9.val=1", "foo", 'print "', 'if("a"<"b")', "if(1=1)", "vis b9,1"]
)
def test_code_that_cannot_be_run(line: str) -> None:
    """A page's own mistake is told to whoever wrote the page, with its place."""
    with pytest.raises(PageError, match=r"only\.b0\.release"):
        tapped((line, "{", "}") if line.startswith("if") else (line,))


def test_events_that_never_end() -> None:
    with pytest.raises(PageError, match="never end"):
        display(page_of(preinitialize=("page 0",)))


# -- what it draws, pixel by pixel where it matters

WHITE, RED, GREEN, BLUE = 0xFFFF, 0xF800, 0x07E0, 0x001F


def pixels(shown: Display) -> np.ndarray:
    return np.asarray(draw(shown))


def inked(shown: Display, colour: int) -> np.ndarray:
    return np.argwhere((pixels(shown) == rgb(colour)).all(axis=2))


def test_colours_of_sixteen_bits_and_dark_without_power() -> None:
    colours = (0, 0, 0), (255, 255, 255), (255, 0, 0), (0, 255, 0), (0, 0, 255)
    assert tuple(map(rgb, (0, WHITE, RED, GREEN, BLUE))) == colours
    assert not pixels(Display(PAGES)).any()


def test_the_ground_is_the_pages_own_and_begins_anew_with_it() -> None:
    shown = display(page_of(bco=BLUE))
    for instruction, colour in (("only.bco=63488", RED), ("page only", BLUE)):
        tell(shown, instruction)
        assert len(inked(shown, colour)) == 800 * 480


def test_a_component_is_where_the_editor_put_it() -> None:
    text = Component("text", "t0", 1, 30, 40, 100, 50, {"txt": "", "bco": RED, "font": 0})
    found = inked(display(page_of(text, bco=BLUE)), RED)
    assert (found.min(axis=0) == (40, 30)).all()
    assert (found.max(axis=0) == (89, 129)).all()


@pytest.mark.parametrize(("across", "down"), [(0, 0), (1, 1), (2, 2)])
def test_text_stands_where_it_is_asked_to(across: int, down: int) -> None:
    own = {"txt": "Hg", "txt_maxl": 2, "font": 0, "xcen": across, "ycen": down}
    colours = {"bco": WHITE, "pco": RED}
    found = inked(display(page_of(Component("text", "t0", 1, 0, 0, 300, 200, own | colours))), RED)
    middle = found.mean(axis=0)
    for at, where, size in zip(middle, (down, across), (200, 300), strict=True):
        assert (at < 30, abs(at - size / 2) < 5, at > size - 30)[where]


def test_text_is_cut_at_its_component() -> None:
    own = {"txt": "M" * 20, "txt_maxl": 20, "font": 2, "bco": WHITE, "pco": RED}
    found = inked(display(page_of(Component("text", "t0", 1, 50, 50, 60, 20, own))), RED)
    assert len(found)
    assert (found.min(axis=0) >= (50, 50)).all()
    assert (found.max(axis=0) < (70, 110)).all()


def test_a_button_shows_the_finger_and_nothing_while_it_is_hidden() -> None:
    shown = display(page_of(button("b0", attributes={"bco": RED, "bco2": GREEN})))

    deeds = (shown.take, lambda: shown.press("b0"), shown.release, lambda: tell(shown, "vis b0,0"))
    for deed, seen in zip(deeds, ([RED], [GREEN], [RED], []), strict=True):
        deed()
        assert [colour for colour in (RED, GREEN) if len(inked(shown, colour))] == seen


def test_a_switch_shows_its_state() -> None:
    own = {"txt": "", "val": 0, "bco0": RED, "bco1": GREEN}
    shown = display(page_of(Component("dual_state", "bt0", 1, 0, 0, 100, 50, own)))
    assert len(inked(shown, RED)) == 5000
    tell(shown, "bt0.val=1")
    assert len(inked(shown, GREEN)) == 5000


def test_later_components_lie_over_earlier() -> None:
    parts = [
        Component("text", f"t{n}", n, at, at, 100, 100, {"txt": "", "font": 0, "bco": colour})
        for n, at, colour in ((2, 50, GREEN), (1, 0, RED))
    ]
    shown = display(page_of(*parts))
    assert (len(inked(shown, GREEN)), len(inked(shown, RED))) == (10_000, 7_500)


def test_a_curve_is_as_high_as_its_points() -> None:
    own = {"ch": 2, "gdw": 0, "gdh": 0, "bco": 0, "pco0": RED, "pco1": GREEN}
    shown = display(page_of(Component("waveform", "s0", 1, 100, 100, 50, 80, own), bco=BLUE))
    tell(shown, "add 1,0,30")
    assert inked(shown, RED).tolist() == [[179 - 30, 100]]
    tell(shown, *["add 1,0,30"] * 49, *["add 1,1,200"] * 50)
    rows, columns = inked(shown, RED).T
    assert (columns.min(), columns.max()) == (100, 149)
    assert set(rows) <= {148, 149, 150}
    assert inked(shown, GREEN)[:, 0].min() == 100  # what is too high stays at the edge


def test_a_grid_begins_at_the_lower_left() -> None:
    own = {"gdw": 20, "gdh": 30, "gdc": RED, "bco": 0}
    found = inked(display(page_of(Component("waveform", "s0", 1, 100, 100, 50, 80, own))), RED)
    rows, columns = (np.unique(each, return_counts=True) for each in found.T)
    assert [row for row, many in zip(*rows, strict=True) if many == 50] == [119, 149, 179]
    assert [column for column, many in zip(*columns, strict=True) if many == 80] == [100, 120, 140]


def test_a_page_is_a_png() -> None:
    shown = display()
    with Image.open(BytesIO(png(shown))) as read:
        assert (read.format, read.size) == ("PNG", (800, 480))
        assert (np.asarray(read) == pixels(shown)).all()
