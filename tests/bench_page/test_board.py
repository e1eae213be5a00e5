"""What a hand at the bench does to the board, and what the board shows of it; without a browser."""

import gc
import json
import tracemalloc
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from benches import Seated, board_of
from rig.firmware import EXAMPLES, changed, example
from suite import amount

from heatwright.cli.bench import store
from heatwright.cli.bench.recorded import Recorded, Unsaid
from heatwright.cli.bench.store import Chart, Roll
from heatwright.cli.beside import with_scenario
from heatwright.sim.device import AvrDevice
from heatwright.sim.scenario import actions

ALL = ("barrel", "chamber", "dryer", "extruder", "fabricator", "feeder", "hotplate", "incubator",
       "kiln", "kiln_uno", "press", "printer")  # fmt: skip
DOOR = changed("chamber", ("\nsafety:", "\nsafety:\n  inputs: {door: {pin: D2, trips: false}}"))


def test_in_real_time_a_step_ends_that_is_no_whole_number_of_cycles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A period of 250 ms has three steps: the board stood still at the end of the first."""
    board = board_of("feeder")
    through, slices = board._run_and_act, list[float]()

    def run(end_s: float) -> None:
        slices.append(end_s)
        assert len(slices) < 100
        through(end_s)

    monkeypatch.setattr(board, "_run_and_act", run)
    from_s, step_s = board.world.now_s, board.world.step_s
    assert 0.1 < step_s * board.world.device.avr.clock_hz % 1 < 0.9
    for _ in range(6):
        board.world.act_within(board._run_in_slices)
    assert board.world.now_s == pytest.approx(from_s + 6 * step_s)


def test_a_key_that_is_held_repeats_and_a_scenario_plays_it_again(tmp_path: Path) -> None:
    seat = Seated("kiln_uno", 2.0)
    seat.press("left")
    before_c = seat.state["loops"]["chamber"]["setpoint_c"]
    seat.press("up", held_s=3.0)
    seat.run(3.0)
    set_c = seat.state["loops"]["chamber"]["setpoint_c"]
    assert set_c > before_c + 3
    *_, saved, _ = seat.board.scenario().splitlines()
    assert saved.endswith(' press: "up", held: "3.00 s"}')
    file = tmp_path / "scenario.yaml"
    file.write_text(seat.board.scenario(), encoding="utf-8")
    simulation = with_scenario(example("kiln_uno"), file, None).simulated
    again = Seated("kiln_uno")
    for action in actions(simulation.scenario):
        again.board.later(action.time_s, partial(again.world.do, action))
    again.run(seat.world.now_s)
    assert again.state["loops"]["chamber"]["setpoint_c"] == set_c


@pytest.mark.parametrize("speed", [0.0, 1.0])
def test_each_of_two_quick_presses_counts(speed: float) -> None:
    """Between them passes less than a press takes on the board."""
    seat = Seated("chamber", 2.0)
    seat.board.set_speed(speed)
    for key, wait_s in (("up", 0.03), ("up", 0.15), ("down", 0.03), ("up", 1.0)):
        seat.at("lcd_keypad", key=key, down=True)
        seat.run(0.01)
        seat.at("lcd_keypad", key=key, down=False, held_s=0.01)
        seat.run(wait_s)
    assert seat.of("lcd_keypad")["rows"][1].startswith("Set temp 40")
    seat.at("lcd_keypad", key="up", down=True)
    seat.at("lcd_keypad", key="down", down=True)  # the other hand: UP is let go for it
    seat.at("lcd_keypad", key="down", down=False, held_s=0.3)
    if speed:
        seat.at("lcd_keypad", key="up", down=False, held_s=0.4)
    seat.run(1.0)
    assert seat.of("lcd_keypad")["held"] is None
    presses = [line for line in seat.board.scenario().splitlines() if "press:" in line]
    assert len(presses) == {0.0: 5, 1.0: 6}[speed]


@pytest.mark.parametrize(
    ("board_s", "finger_s", "saved"),
    [(0.3, 3.0, ""), (3.0, 3.0, ', held: "3.00 s"'), (3.0, 0.3, ', held: "3.00 s"')],
)
def test_a_key_is_saved_with_the_boards_time(board_s: float, finger_s: float, saved: str) -> None:
    seat = Seated("kiln_uno", 2.0)
    seat.board.set_speed(min(1.0, board_s / finger_s))
    seat.at("lcd_keypad", key="up", down=True)
    seat.run(board_s)
    seat.at("lcd_keypad", key="up", down=False, held_s=finger_s)
    assert seat.board.scenario().splitlines()[-2].endswith(f' press: "up"{saved}}}')


def test_m105_is_answered_and_the_hosts_own_questions_are_marked() -> None:
    seat = Seated("extruder", 1.0)
    seat.at("gcode", line="M105")
    seat.run(20.0)
    assert seat.state
    lines = seat.lines[str(seat.number("gcode"))]
    mine = [(sent, text) for _, sent, text, by_itself in lines if not by_itself]
    assert (False, "M105") in mine
    assert [text[:5] for sent, text in mine if sent and text.startswith("ok")] == ["ok T:"]
    assert len([text for _, sent, text, by_itself in lines if by_itself and not sent]) >= 3


def test_a_register_is_written_and_all_are_read() -> None:
    seat = Seated("fabricator", 2.0)
    seat.at("modbus_rtu", name="nozzle.setpoint", value=215)
    seat.at("modbus_rtu", name="nozzle.enabled", value=True)
    seat.run(2.0)
    seat.at("modbus_rtu", read=True)
    seat.run(2.0)
    values = seat.of("modbus_rtu")["values"]
    assert (values["nozzle.setpoint"], values["nozzle.enabled"]) == (215, 1)
    assert values["nozzle.setpoint_in_force"] == seat.state["loops"]["nozzle"]["setpoint_c"] == 215
    assert set(values) == {each["name"] for each in seat.board.seats[0].about()["registers"]}
    assert {each["meaning"]: each["bright"] for each in seat.of("indicators")["leds"]}["enabled"]


def test_a_touch_shows_another_page_as_a_picture() -> None:
    seat = Seated("kiln", 2.0)
    touchable = {each["name"]: each for each in seat.of("nextion")["touchable"]}
    assert touchable["bset"]["text"] == "settings"
    seat.board.view.draw(seat.board.store)
    first = seat.board.store.pictures[seat.number("nextion")].tobytes()
    for down in (True, False):
        seat.at("nextion", **({"name": "bset"} if down else {}), down=down)
        seat.run(1.0)
    assert seat.of("nextion")["page"] == "settings"
    seat.board.view.draw(seat.board.store)
    assert seat.board.store.pictures[seat.number("nextion")].tobytes() != first
    seat.board.view.draw(seat.board.store)
    assert seat.board.store.drawn == {seat.number("nextion"): 2}  # nothing has changed since


def test_a_finger_may_be_anywhere_on_the_touch_display_and_slide() -> None:
    seat = Seated("kiln", 2.0)
    settings = next(each for each in seat.of("nextion")["touchable"] if each["name"] == "bset")
    seat.at("nextion", x=0, y=0, down=True)
    seat.at("nextion", down=False)
    seat.run(1.0)
    assert seat.of("nextion")["page"] == "main"
    seat.at("nextion", x=settings["x"] + 1, y=settings["y"] + 1, down=True)
    seat.at("nextion", down=False)
    seat.run(1.0)
    assert seat.of("nextion")["page"] == "settings"
    beyond = {"do": "at", "interface": seat.number("nextion"), "x": 800, "y": 0, "down": True}
    assert "x: 800 is not from 0 to 799." in seat.board.do(beyond)


def test_the_log_answers() -> None:
    seat = Seated("kiln", 2.0)
    seat.at("serial_log", line="help")
    seat.run(2.0)
    assert seat.state
    lines = [text for _, _, text, _ in seat.lines[str(seat.number("serial_log"))]]
    assert lines[0] == "help"
    assert any("clear" in text for text in lines[1:])


def test_a_sensor_that_is_pulled_trips_and_its_heater_goes_off() -> None:
    seat = Seated("chamber")
    seat.press("up")
    seat.fault("unplugged")
    seat.run(10.0)
    assert seat.state["fault"]["id"] == "sensor_no_answer"
    assert seat.state["loops"]["air"]["duty_percent"] == 0
    assert not seat.state["outputs"]["heater"]
    seat.fault("power_cut")
    seat.run(10.0)
    assert seat.state["faults"] == ["unplugged"]  # another chip has the power, and its plug is out
    assert "reading" in seat.missing("air")
    seat.fault("unplugged", on=False)
    seat.run(10.0)
    assert "reading" not in seat.missing("air")
    assert seat.state["faults"] == []


def test_one_place_has_one_fault() -> None:
    """A wire is not open and shorted at once; a chip has one fault at a time."""
    seat = Seated("chamber")
    seat.fault("heater_open")
    seat.fault("switch_shorted_when_hot")
    assert seat.state["faults"] == ["switch_shorted_when_hot"]
    seat.fault("unplugged")
    seat.fault("frozen")
    assert seat.state["faults"] == ["switch_shorted_when_hot", "frozen"]
    seat.fault("switch_shorted_when_hot", on=False)
    seat.fault("heater_open", on=False)  # nothing to mend
    assert seat.state["faults"] == ["frozen"]
    assert not seat.world.wiring.heat


@pytest.mark.parametrize("example", ALL)
def test_each_fault_can_be_brought_and_mended_while_the_board_runs(example: str) -> None:
    seat = Seated(example, 2.0)
    for name, cause in seat.world.breakage.causes.items():
        seat.fault(name)
        seat.run(4.0)  # a program that hangs is reset by then
        assert not cause.lasts or name in seat.world.breakage.active
        seat.fault(name, on=False)
        assert name not in seat.world.breakage.active
    assert not seat.world.wiring.heat
    assert not seat.world.wiring.besides
    seat.run(1.0)
    json.dumps(seat.state, allow_nan=False)


def test_a_heater_that_is_on_misses_nothing_and_one_that_is_off_something() -> None:
    for name in ("chamber", "printer", "dryer", "kiln"):
        seat = Seated(name)
        seat.do("play")
        seen = set()
        for _ in range(400):
            seat.run(0.7)
            for loop, state in seat.state["loops"].items():
                on = seat.state["outputs"][seat.board.controller.loops[loop].heater]
                assert on == state["heater_on"] == (not state["missing"])
                seen.add(on)
        assert seen == {True, False}, name


def test_each_permit_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    seat = Seated("chamber", 2.0)
    assert seat.missing("air") == ["duty"]
    seat.press("up")
    seat.run(2.0)
    assert seat.missing("air") == []
    seat.fault("fan_stopped")
    seat.run(0.1)
    assert "fan" in seat.missing("air")
    seat.fault("fan_stopped", on=False)
    seat.run(30.0)
    seat.fault("unplugged")
    seat.run(10.0)
    assert {"fault", "reading"} <= set(seat.missing("air"))
    seat = Seated("chamber")
    seat.press("up")
    seat.run(2.0)
    seat.fault("hung_main_loop")
    seat.run(0.5)
    assert "main_loop" in seat.missing("air")
    seat = Seated("fabricator", 2.0)
    assert "switched_off" in seat.missing("nozzle")


def test_an_open_door_is_named() -> None:
    seat = Seated(DOOR)
    seat.press("up")
    seat.run(2.0)
    assert seat.missing("air") == []
    seat.world.device.contacts["door"].move(is_open=True)
    seat.run(0.5)
    assert seat.missing("air")[0] == "input"
    assert "door" in seat.state["loops"]["air"]["missing"][0]["text"]


def warmed_k(**sliders: dict[str, Any]) -> float:
    """Return how much the chamber's element has warmed under full heat in 20 s."""
    seat = Seated("chamber")
    for what, order in sliders.items():
        seat.do(what, **order)
    seat.press("up")
    seat.run(20.0)
    return float(seat.state["nodes_c"]["element"]) - 20.0


def test_heat_goes_with_the_square_of_the_supply_and_less_by_the_load() -> None:
    whole_k = warmed_k()
    assert whole_k > 10
    assert warmed_k(supply={"percent": 50}) == pytest.approx(whole_k / 4, abs=0.02)
    # What is taken away is so from the start: a second and a half before the heat.
    assert warmed_k(load={"heater": "heater", "watts": 120}) < whole_k / 2 + 0.02
    assert warmed_k(load={"heater": "heater", "watts": 0}) == whole_k


def test_the_machine_follows_its_surroundings() -> None:
    seat = Seated("chamber")
    seat.do("ambient", ambient_c=5)
    seat.run(7200.0)
    assert seat.state["nodes_c"]["walls"] < 19


def test_filament_takes_heat_along() -> None:
    temperatures_c = []
    for speed in (0, 20):
        seat = Seated("extruder", 1.0)
        seat.at("gcode", line="M104 S200")
        seat.do("feed", mm_per_s=speed)
        seat.run(40.0)
        temperatures_c.append(max(seat.state["nodes_c"].values()))
    assert temperatures_c[1] < temperatures_c[0] - 1


def test_variables_have_their_names() -> None:
    seat = Seated("chamber", 3.0)
    found = seat.board.view.variables()
    assert found["loop_air:loop_air.setpoint_c"] == 20
    assert found["loop_air:loop_air.steps"] == seat.world.device.read("loop_air.steps")
    assert list(found) == seat.board.store.about["variables"]


@pytest.mark.parametrize("example", ["chamber", "kiln", "extruder", "fabricator"])
def test_memory_does_not_grow(example: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody takes the recorded steps, lines and pins but the page, and it keeps only so many."""
    monkeypatch.setattr(store, "MOST_POINTS", 200)
    monkeypatch.setattr(store, "MOST_LINES", 50)
    seat = Seated(example)
    seat.do("play")

    def hours(count: float) -> int:
        for _ in range(round(60 * count)):
            seat.run(60.0)
            seat.board.tell(force=True)
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        half = amount("bench_page_hours") / 2
        before = hours(half)  # what has a bound is full by then: matrices of the plant, caches
        grown = hours(half) - before
    finally:
        tracemalloc.stop()
    assert grown < 200_000, f"{grown} bytes"


def test_a_chart_keeps_its_length_and_its_ends() -> None:
    chart = Chart()
    for at in range(100_000):
        chart.add([(float(at),)])
    assert len(chart.points) <= store.MOST_POINTS
    assert (chart.points[0], chart.points[-1]) == ((0.0,), (99_999.0,))
    assert chart.epoch > 0
    assert chart.points == sorted(chart.points)


def test_a_roll_tells_each_line_once() -> None:
    roll, told, number = Roll(), [], 0
    for at in range(3000):
        roll.add([at])
        if at % 7 == 0:
            lines, number = roll.since(number)
            told += lines
    assert told == list(range(2997 + 1))[: len(told)]
    assert (len(roll.lines), roll.since(0)[0][0]) == (store.MOST_LINES, 2000)


def test_what_was_done_is_played_again_by_simulate(heatwright: Any, tmp_path: Path) -> None:
    seat = Seated("chamber", 5.0)
    for key in ("up", "up", "up", "down"):
        seat.press(key)
    seat.do("ambient", ambient_c=15)
    seat.do("ambient", ambient_c=20)
    seat.run(60.0)
    text = seat.board.scenario()
    assert [each.get("press") for each in yaml.safe_load(text)["scenario"]] == [
        "up", "up", "up", "down", None,
    ]  # fmt: skip
    Path("done.yaml").write_text(text, "utf-8")
    found = heatwright("simulate chamber.yaml --scenario done.yaml --json").json
    assert found["display"][1] == seat.of("lcd_keypad")["rows"][1] == "Set temp 40°C   "
    spec = yaml.safe_load(Path("chamber.yaml").read_text("utf-8"))
    spec["simulation"]["scenario"] = yaml.safe_load(text)["scenario"]
    Path("own.yaml").write_text(yaml.safe_dump(spec, allow_unicode=True), "utf-8")
    heatwright("check --quick own.yaml")


@pytest.mark.parametrize(
    ("example", "kind", "orders"),
    [
        ("kiln", "nextion", [{"name": "bprog", "down": True}, {"down": False}]),
        ("extruder", "gcode", [{"line": 'M117 "quoted" #{}'}]),
        ("fabricator", "modbus_rtu", [{"name": "nozzle.setpoint", "value": 215.5}]),
    ],
)
def test_each_interfaces_orders_are_good_in_a_scenario(
    heatwright: Any, example: str, kind: str, orders: list[dict[str, Any]]
) -> None:
    seat = Seated(example, 2.0)
    for order in orders:
        seat.at(kind, **order)
        seat.run(1.0)
    Path("done.yaml").write_text(seat.board.scenario(), "utf-8")
    heatwright(f"simulate {EXAMPLES / example}.yaml --scenario done.yaml --for 5s --json")


@pytest.mark.parametrize("example", ALL)
def test_the_specs_own_scenario_is_played_and_can_be_saved(example: str) -> None:
    seat = Seated(example)
    seat.do("play")
    found = yaml.safe_load(seat.board.scenario())["scenario"]
    spec = yaml.safe_load((EXAMPLES / f"{example}.yaml").read_text("utf-8"))
    wanted = spec["simulation"]["scenario"]
    assert [set(each) for each in found] == [set(each) for each in wanted]
    assert [each.get("send") for each in found] == [each.get("send") for each in wanted]


def test_too_many_events_are_no_scenario() -> None:
    recorded = Recorded()
    for at in range(100):
        recorded.event(at, {"press": "up"})
    with pytest.raises(Unsaid, match="100 events are too many: a scenario has at most 99"):
        recorded.text("chamber.yaml", 200.0)


@pytest.mark.parametrize(
    "order",
    [
        {}, {"do": "halt"}, {"do": ["at"]}, {"do": "at"}, {"do": "at", "interface": 7},
        {"do": "at", "interface": True}, {"do": "at", "interface": 0, "key": "eject", "down": True},
        {"do": "at", "interface": 0, "key": "up"},
        {"do": "at", "interface": 0, "key": "up", "down": False, "held_s": 1e9},
        {"do": "at", "interface": 0, "key": "up", "down": False, "held_s": float("nan")},
        {"do": "at", "interface": 1, "line": "M105"},
        {"do": "fault", "fault": "meteor", "on": True}, {"do": "fault", "fault": "unplugged"},
        {"do": "ambient", "ambient_c": "warm"}, {"do": "ambient", "ambient_c": -300},
        {"do": "supply", "percent": 1e6}, {"do": "load", "heater": "fan", "watts": 1},
        {"do": "load", "heater": "heater", "watts": 1e6}, {"do": "speed", "speed": 1e9},
        {"do": "speed", "speed": -1}, {"do": "feed", "mm_per_s": True},
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_refused(order: dict[str, Any]) -> None:
    seat = Seated("chamber")
    assert seat.board.do(order)
    assert len(seat.board.recorded) == 0
    seat.run(1.0)
    assert seat.state["fault"] is None
    assert isinstance(seat.world.device, AvrDevice)
