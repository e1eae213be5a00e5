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
MINUTE_S = 60.0


def said(desk: KilnDesk, since_s: float) -> list[str]:
    return [each.text for each in desk.display.history if each.time_s > since_s]


def test_it_begins_with_everything(desk: KilnDesk) -> None:
    texts = said(desk, 0.0)
    assert texts[0] == "bkcmd=0"
    assert desk.display.errors == []
    page = display_pages(desk.controller)[0]
    set_by_board = {text.split("=")[0].split(".")[1] for text in texts if text.startswith("main.")}
    numbers = {each.name for each in page.components if each.kind in ("number", "dual_state")}
    assert numbers <= set_by_board
    assert desk.shows("main.temp.val") == 20
    assert desk.shows("main.pname.txt") == "fuse"


def test_only_what_has_changed_is_said(desk: KilnDesk) -> None:
    """A cold kiln has nothing to say until all is said again."""
    desk.run(10.0)
    now_s = desk.device.time_s
    desk.run(15.0)
    assert said(desk, now_s) == []


def test_everything_is_said_again(desk: KilnDesk) -> None:
    """What was lost on the way comes right by itself."""
    first = {text.split("=")[0] for text in said(desk, 0.0) if text.startswith("main.")}
    desk.display.display.memory.parts[0]["temp"].values["val"] = 999
    now_s = desk.device.time_s
    desk.run(AGAIN_S + 2.0)
    assert first <= {text.split("=")[0] for text in said(desk, now_s)}
    assert desk.shows("main.temp.val") == 20


def test_one_instruction_at_a_time(desk: KilnDesk) -> None:
    """In any row of them each takes its two ticks; only the work of a tick moves them about."""
    desk.tap("bprog", "back", "bdebug", "back")
    desk.display.send("#8 1;")
    desk.run(3.0)
    times = [each.time_s for each in desk.display.history]
    assert len(times) > 50
    for many in (1, 5, 20):
        spans = [later - first for first, later in zip(times, times[many:], strict=False)]
        assert min(spans) > many * EVERY_S - TICK_S
    assert desk.display.shortest_gap_s > EVERY_S - TICK_S / 2


def test_a_page_gets_everything_when_it_is_shown(desk: KilnDesk) -> None:
    desk.tap("bprog")
    assert desk.display.page == "programs"
    assert desk.shows("programs.name1.txt") == "fuse"
    desk.tap("b1")
    assert desk.display.page == "points"
    desk.run(1.0)
    rows = [[desk.shows(f"{column}{row}.txt") for column in "kmt"] for row in range(1, 9)]
    assert rows[0] == ["min", "60", "540"]
    assert rows[1][:2] == ["hold", "30"]
    assert rows[6] == ["min", "240", "50"]
    assert rows[7] == ["", "", ""]
    assert desk.display.errors == []


def test_the_settings_and_the_control(desk: KilnDesk) -> None:
    desk.tap("bset")
    desk.run(1.0)
    assert float(desk.shows("sp.txt")) == 20
    assert float(desk.shows("crit.txt")) == 1150
    assert desk.shows("type.txt") == "K"
    desk.tap("back", "bdebug")
    desk.run(1.0)
    algorithm = desk.controller.loops["chamber"].algorithm
    assert [float(desk.shows(f"{gain}.txt")) for gain in ("kp", "ki", "kd")] == pytest.approx(
        [getattr(algorithm, gain) for gain in ("kp", "ki", "kd")], rel=1e-6
    )
    assert desk.display.errors == []


def test_a_running_program_on_the_main_page(desk: KilnDesk) -> None:
    desk.display.send("#8 1;")
    desk.run(5 * MINUTE_S + 5.0)
    assert desk.read("program.state") == RUNNING
    assert (desk.shows("programm.val"), desk.shows("point.val")) == (1, 1)
    assert [desk.shows(f"{name}.val") for name in ("day", "hour1", "minute1")] == [0, 0, 5]
    assert [desk.shows(f"{name}.val") for name in ("day2", "hour2", "minute2")] == [0, 0, 5]
    setpoint_c = desk.read("loop_chamber.setpoint_c")
    assert abs(int(desk.shows("set.val")) - setpoint_c) <= 1.5
    assert abs(int(desk.shows("temp.val")) - desk.read("loop_chamber.temperature_c")) <= 1.5
    assert desk.shows("bt1.val") == 1
    assert float(str(desk.shows("energy.txt")).split()[0]) >= 0
    assert desk.display.errors == []


def test_the_charts_grow(desk: KilnDesk) -> None:
    """A pixel a minute on the first page, a pixel a second on the other; in pixels of height."""
    desk.display.send("#8 1;")
    desk.run(6 * MINUTE_S)
    waveform = desk.display.display.memory.parts[0]["chart"].waveform
    assert waveform is not None
    assert 5 <= len(waveform.channels[0]) <= 7
    top_c = 1200
    height = 180 * desk.read("loop_chamber.temperature_c") / top_c
    assert abs(waveform.channels[0][-1] - height) <= 180 * 10 / top_c + 1
    desk.tap("bdebug")
    desk.run(20.0)
    number = next(each.id for each in display_pages(desk.controller) if each.name == "debug")
    waveform = desk.display.display.memory.parts[number]["chart"].waveform
    assert waveform is not None
    assert 18 <= len(waveform.channels[0]) - len(waveform.channels[1]) + 20 <= 22
    assert 19 <= len(waveform.channels[0]) <= 22
    desk.tap("back")
    desk.run(5.0)
    main = desk.display.display.memory.parts[0]["chart"].waveform
    assert main is not None
    assert len(main.channels[0]) >= 6, "what was there is drawn again"
    assert desk.display.errors == []


@pytest.mark.parametrize(
    ("baud", "heard"), [(113_000, True), (119_000, True), (100_000, False), (57_600, False)]
)
def test_a_display_hears_what_it_can_sample(kiln: Built, baud: int, heard: bool) -> None:
    """The board's clock gives 117 647 baud for 115 200; each bit is sampled in its middle."""
    desk = KilnDesk(kiln)
    desk.display.line.baud = baud
    desk.run(3.0)
    assert ("bkcmd=0" in said(desk, 0.0)) is heard
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


def test_what_is_shown_can_be_seen(desk: KilnDesk, kiln: Built) -> None:
    """The picture differs from that of a display which nobody told anything."""
    bare = Display(display_pages(kiln.controller))
    bare.start()
    told = draw(desk.display.display)
    assert told.tobytes() != draw(bare).tobytes()
