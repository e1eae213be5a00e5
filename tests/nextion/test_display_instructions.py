"""The simulated display follows instructions, and refuses others, as the manual has it."""

import pytest
from small_pages import PAGES, STARTED, display, tell

from heatwright.sim.interfaces.nextion_codes import Code
from heatwright.sim.interfaces.nextion_display import BUFFER_BYTES, Display

REFUSED = {
    Code.INVALID_INSTRUCTION: ("foo", "", "if(n0.val==1)", "Page first", "n0.val=1+"),
    Code.INVALID_COMPONENT: ("vis b9,0", "vis 99,0", "click gone,1"),
    Code.INVALID_PAGE: ("page gone", "page 2", "page -1"),
    Code.INVALID_WAVEFORM: ("add 1,0,3", "add 99,0,3", "add 7,2,3", "cle 7,2", "cle 1,0"),
    Code.INVALID_VARIABLE: (
        "n0.val=1 2", "n9.val=1", "n0.txt=1", "q=1", "gone.n0.val=1", "away.n0.val=1",
        "first.n0.val.x=1", "get b",
    ),
    Code.INVALID_OPERATION: (
        "add 7,0,256", 'n0.val="a"', "t0.txt=5", 't0.txt="a"*2', "n0.val=1/0", "n0.x=5", "dim=101",
        "dp=1", "bkcmd=4",
    ),
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
        ("tm0.en=1", "tm0.en", 1), ("dim=50", "dim", 50), ("sys0=3", "sys0", 3),
    ],
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
