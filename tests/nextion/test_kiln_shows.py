"""What the board tells the display, on the binary."""

import pytest
from kiln_desk import RUNNING, Built, KilnDesk

from heatwright.sim.interfaces.nextion_display import Display
from heatwright.sim.interfaces.nextion_screen import draw
from heatwright.spec.nextion import display_pages

TICK_S = 0.01
EVERY_S = 2 * TICK_S
"""Between two instructions, at least."""
AGAIN_S = 30.0
"""All is said again so often."""
TOP_C, HEIGHT = 1200, 180
"""Of the charts, degrees and pixels."""


def said(desk: KilnDesk, since_s: float = 0.0) -> list[str]:
    return [each.text for each in desk.display.history if each.time_s > since_s]


def drawn(desk: KilnDesk, page: str, channel: int = 0) -> list[int]:
    """Return the points of a page's chart."""
    number = next(each.id for each in display_pages(desk.controller) if each.name == page)
    waveform = desk.display.display.memory.parts[number]["chart"].waveform
    assert waveform is not None
    return list(waveform.channels[channel])


def test_everything_is_said_at_the_start_and_again(desk: KilnDesk) -> None:
    """A cold kiln has nothing to say in between; what was lost on the way comes right by itself."""
    texts = said(desk)
    assert texts[0] == "bkcmd=0"
    first = {text.split("=")[0] for text in texts if text.startswith("main.")}
    page = display_pages(desk.controller)[0]
    numbers = {f"main.{each.name}" for each in page.components
               if each.kind in {"number", "dual_state"}}  # fmt: skip
    assert numbers <= {name.rpartition(".")[0] for name in first}
    assert desk.shows("main.temp.val") == 20
    assert desk.shows("main.pname.txt") == "fuse"
    bare = Display(display_pages(desk.controller))
    bare.start()
    assert draw(desk.display.display).tobytes() != draw(bare).tobytes(), "it can be seen"
    desk.run(10.0)
    now_s = desk.device.time_s
    desk.run(15.0)
    assert said(desk, now_s) == []
    desk.display.display.memory.parts[0]["temp"].values["val"] = 999
    desk.run(AGAIN_S - 15.0 + 2.0)
    assert first <= {text.split("=")[0] for text in said(desk, now_s)}
    assert desk.shows("main.temp.val") == 20
    assert desk.display.errors == []


def test_one_instruction_at_a_time(desk: KilnDesk) -> None:
    """In any row of them each takes its two ticks; only the work of a tick moves them about."""
    desk.tap("bprog", "back", "bdebug", "back")
    desk.do("order 8 1")
    times = [each.time_s for each in desk.display.history]
    assert len(times) > 50
    for many in (1, 5, 20):
        spans = [later - first for first, later in zip(times, times[many:], strict=False)]
        assert min(spans) > many * EVERY_S - TICK_S
    assert desk.display.shortest_gap_s > EVERY_S - TICK_S / 2


def test_a_running_program_and_its_charts(desk: KilnDesk) -> None:
    """A pixel a minute on the first page, a pixel a second on the other; in pixels of height."""
    desk.display.send("#8 1;")
    desk.run(305.0)
    assert desk.read("program.state") == RUNNING
    names = ("programm", "point", "day", "hour1", "minute1", "day2", "hour2", "minute2", "bt1")
    assert [desk.shows(f"{name}.val") for name in names] == [1, 1, 0, 0, 5, 0, 0, 5, 1]
    for name, variable in (("set", "setpoint_c"), ("temp", "temperature_c")):
        assert abs(int(desk.shows(f"{name}.val")) - desk.read(f"loop_chamber.{variable}")) <= 1.5
    assert float(str(desk.shows("energy.txt")).split()[0]) >= 0
    desk.run(55.0)
    points = drawn(desk, "main")
    assert 5 <= len(points) <= 7
    height = HEIGHT * desk.read("loop_chamber.temperature_c") / TOP_C
    assert abs(points[-1] - height) <= HEIGHT * 10 / TOP_C + 1
    desk.tap("bdebug")
    desk.run(20.0)
    points = drawn(desk, "debug")
    assert 18 <= len(points) - len(drawn(desk, "debug", 1)) + 20 <= 22
    assert 19 <= len(points) <= 22
    desk.tap("back")
    desk.run(5.0)
    assert len(drawn(desk, "main")) >= 6, "what was there is drawn again"
    assert desk.display.errors == []


@pytest.mark.parametrize(
    ("baud", "heard"), [(113_000, True), (119_000, True), (100_000, False), (57_600, False)]
)
def test_a_display_hears_what_it_can_sample(kiln: Built, baud: int, heard: bool) -> None:
    """The board's clock gives 117 647 baud for 115 200; each bit is sampled in its middle."""
    desk = KilnDesk(kiln)
    desk.display.line.baud = baud
    desk.run(3.0)
    assert ("bkcmd=0" in said(desk)) is heard
    assert (desk.display.errors == []) is (desk.display.instructions == 0 or heard)


def test_a_display_that_starts_anew(desk: KilnDesk) -> None:
    desk.run(5.0)
    desk.display.unplug()
    desk.run(12.0)
    desk.display.plug()
    now_s = desk.device.time_s
    desk.run(3.0)
    assert "bkcmd=0" in said(desk, now_s)
    assert desk.shows("main.temp.val") == 20
    assert desk.shows("main.pname.txt") == "fuse"
    assert desk.display.errors == []
