"""Touches, events and timers of the simulated display."""

import pytest
from small_pages import PAGES, button, display, page_of, tell

from heatwright.sim.interfaces.nextion_display import Display
from heatwright.sim.interfaces.nextion_events import PageError
from heatwright.spec.nextion import Component


def tap(shown: Display, name: str) -> bytes:
    """Touch a component; return what the display says."""
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
    with pytest.raises(LookupError, match=name):
        display().press(name)


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
    with pytest.raises(LookupError, match="lies over under"):
        shown.press("under")
    for place in ((5, 5), (60, 30), (700, 400)):
        shown.touch(*place)
        shown.release()
    assert shown.take() == b"uo"


def test_nobody_presses_anything_without_power() -> None:
    with pytest.raises(LookupError):
        Display(PAGES).press("b0")


def test_timers_run_while_their_page_is_shown() -> None:
    shown = display()
    shown.pass_time(1000)
    assert shown.value("n1.val") == 4
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
    """Return what a button with this code makes a display print."""
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


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("1==1", True), ("1!=1", False), ("2<=2", True), ("3>2", True), ("-1<0", True),
        ('"a"=="a"', True), ('"a"!="a"', False), ("1==2||3==3", True), ("1==1&&2==3", False),
        ('"<"=="<"', True), ("1 == 1", True),
    ],
)  # fmt: skip
def test_conditions(condition: str, holds: bool) -> None:
    assert tapped((f"if({condition})", "{", 'print "x"', "}")) == b"x" * holds


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
