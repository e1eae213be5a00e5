"""Programs, their segments, and the orders to them."""

from typing import Any

import pytest
from rig.bad_specs import bases
from rig.specs import changed

from heatwright.spec import Event, Program, ProgramOrder, Programs, Segment, SpecError, load_text


def programs(**keys: Any) -> Programs:
    return Programs.model_validate({"loop": "chamber", **keys})


def test_as_many_places_as_are_stored() -> None:
    stored = tuple({"name": str(i), "segments": ({"hold": "1 h"},)} for i in range(5))
    assert programs(stored=stored).places == 5
    assert programs(stored=stored, places=7).places == 7
    assert programs(places=1).places == 1


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("5 K", (5.0, 7200.0)),
        ({"within": "5 K"}, (5.0, 7200.0)),
        ({"limit": "30 min"}, (8.0, 1800.0)),
        ({"within": "5 K", "limit": "30 min"}, (5.0, 1800.0)),
        ("off", None),
    ],
)
def test_ways_to_hold_back(written: object, expected: tuple[float, float] | None) -> None:
    found = programs(hold_back=written).hold_back
    assert (found and (found.within_k, found.limit_s)) == expected


def test_a_program_never_resumes_unless_told() -> None:
    stops = programs(after_power_loss="stop").after_power_loss
    assert (stops.resume_within_k, stops.otherwise) == (0.0, "stop")


@pytest.mark.parametrize(
    ("written", "kind", "values"),
    [
        ({"to": "540 °C", "over": "60 min"}, "over", (540.0, 3600.0, None, None)),
        ({"to": "540 °C", "at": "150 K/h"}, "rate", (540.0, None, 150.0, None)),
        ({"to": "540 °C", "at": "2.5 K/min"}, "rate", (540.0, None, 150.0, None)),
        ({"to": "540 °C", "at": "as fast as possible"}, "fast", (540.0, None, None, None)),
        ({"hold": "30 min"}, "hold", (None, None, None, 1800.0)),
        ({"hold": "until operator"}, "until", (None, None, None, None)),
    ],
)
def test_the_forms_of_a_segment(
    written: dict[str, str], kind: str, values: tuple[float | None, ...]
) -> None:
    segment = Segment.model_validate(written)
    assert segment.kind == kind
    assert (segment.to_c, segment.over_s, segment.at_k_per_h, segment.hold_s) == values
    assert (segment.fast, segment.until) == (kind == "fast", kind == "until")


def test_a_name_may_fill_the_display() -> None:
    hold = ({"hold": "1 h"},)
    assert Program.model_validate({"name": "123456789012", "segments": hold}).name


@pytest.mark.parametrize(
    ("written", "order"),
    [
        ("start 1", ProgramOrder("start", 1)),
        ("pause", ProgramOrder("pause")),
        ("resume", ProgramOrder("resume", 0)),
        ("skip", ProgramOrder("skip", 0)),
        ("jump 7", ProgramOrder("jump", 7)),
        ("stop", ProgramOrder("stop", 0)),
    ],
)
def test_orders(written: str, order: ProgramOrder) -> None:
    assert Event.model_validate({"at": "9 s", "program": written}).program == order


def test_what_is_sent_may_have_filled_a_place() -> None:
    """In place 2, from which nothing could start otherwise."""
    kiln = (
        bases()["simulated_kiln"],
        ("    - {for: 8 h}", "    - {at: 9 s, program: start 2}\n    - {for: 8 h}"),
    )
    order = "program: start 1"
    assert load_text(changed(*kiln, (order, 'send: "#13 2;"')))
    with pytest.raises(SpecError, match="program 2 is empty"):
        load_text(changed(*kiln))
