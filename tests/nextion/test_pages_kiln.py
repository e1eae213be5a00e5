"""The pages of every spec with a touch display: all fits, nothing overlaps, all code can be run;
the documents for the Nextion editor say all of them, and nothing breaks those."""

import copy
import json
import re
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from hosted_kiln import PAGE, SPEC, TOUCHED
from rig.firmware import EXAMPLE_NAMES, changed, example, files_of, spec_of, whole

from heatwright.generator import compare, plan_firmware, render, write
from heatwright.generator.plan.interfaces.nextion.documents import KINDS
from heatwright.sim.faults.catalogue import catalogue
from heatwright.sim.interfaces.nextion.codes import LONGEST_NAME
from heatwright.sim.interfaces.nextion.display import Display
from heatwright.sim.interfaces.nextion.events import Choice, read
from heatwright.sim.interfaces.nextion.screen import font
from heatwright.spec import Controller, facts_of, load
from heatwright.spec.nextion import FONTS, HEIGHT, WIDTH, Page, display_pages

FILES = files_of(SPEC)
SEEN = ("text", "number", "button", "dual_state", "waveform")
FIGURES = 12  # fields of so many characters or less hold figures; longer ones hold words
DIGITS = {"temp": 4, "set": 4, "duty": 3, "ot": 3, "settled": 6}
"""Digits of numbers that are not days, hours, minutes or places."""
COMMAND = re.compile(rb"(#\d+( [^#;]*)?;)*")

DISPLAYS = [pages for name in EXAMPLE_NAMES if (pages := display_pages(example(name).controller))]
PAGES = {page.name: page for pages in DISPLAYS for page in pages}
every_page = pytest.mark.parametrize("page", PAGES.values(), ids=PAGES)


@every_page
def test_all_is_on_the_screen_and_nothing_overlaps(page: Page) -> None:
    seen = [each for each in page.components if each.kind in SEEN]
    for each in seen:
        assert 0 <= each.x <= each.x + each.w <= WIDTH, each.name
        assert 0 <= each.y <= each.y + each.h <= HEIGHT, each.name
    for one, other in combinations(seen, 2):
        beside = one.x + one.w <= other.x or other.x + other.w <= one.x
        above = one.y + one.h <= other.y or other.y + other.h <= one.y
        assert beside or above, f"{one.name} and {other.name}"


@every_page
def test_texts_and_names_fit(page: Page) -> None:
    assert f'print "#21 {page.id};"' in page.postinitialize, "the board is told which page it is"
    for number, each in enumerate(page.components, 1):
        assert each.id == number
        assert max(len(page.name), len(each.name)) <= LONGEST_NAME
        if each.kind not in SEEN or each.kind == "waveform":
            continue
        height = FONTS[int(each.attributes["font"])]
        longest = int(each.attributes.get("txt_maxl", DIGITS.get(each.name, 2)))
        text = str(each.attributes.get("txt", "")) or "0" * min(longest, FIGURES)
        assert font(height).getlength(text) <= each.w, f"{each.name}: {text}"
        assert height <= each.h, each.name
    assert len({each.name for each in page.components}) == len(page.components)


@every_page
def test_nothing_stands_behind_a_page_change(page: Page) -> None:
    """It would never be run."""

    def look(code: tuple[str | Choice, ...]) -> None:
        for number, each in enumerate(code):
            if isinstance(each, Choice):
                look(each.then)
                look(each.otherwise)
            elif each.startswith("page "):
                assert number == len(code) - 1, each

    for owner in page.components:
        for event in (owner.press, owner.release, owner.timer):
            look(read(event))


@pytest.mark.parametrize("pages", DISPLAYS, ids=lambda pages: f"{len(pages)} pages")
def test_every_touch_sends_whole_commands(pages: tuple[Page, ...]) -> None:
    """Nothing on any page ends in an error; what is printed is commands, or nothing."""
    shown = Display(pages)
    for number, page in enumerate(pages):
        for each in page.components:
            if not (each.press or each.release):
                continue
            shown.start()
            shown.show(number)
            shown.take()
            shown.press(each.name)
            shown.release()
            sent = shown.take()
            assert COMMAND.fullmatch(sent), f"{page.name}.{each.name}: {sent!r}"
            assert shown.page != page.name or b"#21" not in sent


def after(pages: tuple[Page, ...], *touched: str) -> str:
    shown = Display(pages)
    shown.start()
    shown.show(next(number for number, page in enumerate(pages) if page.name == touched[0]))
    for name in touched[1:]:
        shown.press(name)
        shown.release()
    return shown.page


@pytest.mark.parametrize("pages", DISPLAYS, ids=lambda pages: f"{len(pages)} pages")
def test_every_page_is_reached_and_left(pages: tuple[Page, ...]) -> None:
    """By touches alone, but for the pages of faults, which the board shows; all lead back."""
    firsts = ["main", *(page.name for page in pages if page.name.startswith("fault"))]
    paths = {name: (name,) for name in firsts}
    waiting = list(paths)
    while waiting:
        name = waiting.pop()
        for path in ((*paths[name], each.name) for each in PAGES[name].components if each.release):
            if (to := after(pages, *path)) not in paths:
                paths[to] = path
                waiting.append(to)
    assert set(paths) == {page.name for page in pages}
    for name in paths.keys() - {"main"}:
        back = {"stop": "no"}.get(name, "back")
        assert after(pages, *paths[name], back) != name


# -- the documents for the Nextion editor


def test_the_data_have_every_component_and_every_line() -> None:
    data = FILES["nextion/pages.json"]
    for page, told in zip(display_pages(TOUCHED), json.loads(data)["pages"], strict=True):
        assert (told["id"], told["name"]) == (page.id, page.name)
        assert told["postinitialize"] == list(page.postinitialize)
        for part, other in zip(page.components, told["components"], strict=True):
            assert (other["id"], other["name"]) == (part.id, part.name)
            assert other["place"] == [part.x, part.y, part.w, part.h]
            assert other["attributes"] == dict(part.attributes)
            assert (other["scope"] == "global") == part.shared
            for event in ("press", "release", "timer"):
                assert other.get(event, []) == list(getattr(part, event))


ROW = re.compile(r"\| (\d+) \| `(\w+)` \| (as it is|new ([\w -]+)|copy `([\w.]+)`) \| (.*) \|")
PART = re.compile(r'(\w+) ("(?:[^"\\]|\\.)*"|-?\d+)(?:; |$)')
STEP = re.compile(r"^(?:\| \d.*|`(.+)`, ([\w ]+) Event:\n\n((?:    .*\n)+))", re.MULTILINE)
EVENTS = {"Touch Press": "press", "Touch Release": "release", "Timer": "timer",
          "Preinitialize": "preinitialize", "Postinitialize": "postinitialize"}  # fmt: skip
Made = dict[str, dict[str, Any]]


def built(to_read: str) -> dict[str, Made]:
    """Do with pages and components what the page to read says, as somebody at the editor would."""
    pages: dict[str, Made] = {}
    for text in re.split(r"^## ", to_read, flags=re.MULTILINE)[1:]:
        name = re.match(r"\d+: page `(\w+)`", text)[1]  # type: ignore[index]
        of = re.search(r"^Copy page `(\w+)`", text, re.MULTILINE)
        page = pages[name] = copy.deepcopy(pages[of[1]]) if of else {"": {}}
        for line in STEP.finditer(text):
            if row := ROW.fullmatch(line[0].strip()):
                number, part, how, kind, like, told = row.groups()
                if kind:
                    page[part] = {"kind": kind}
                elif like:
                    other, _, old = like.rpartition(".")
                    page[part] = copy.deepcopy(pages[other or name][old])
                assert how == "as it is" or kind or like
                told_of_it = PART.findall(unmarked(told))
                page[part] |= {key: json.loads(value) for key, value in told_of_it}
                page[part]["id"] = int(number)
            else:
                owner, event, lines = line[1], line[2], line[3]
                code = [each[4:] for each in lines.splitlines()]
                part = "" if owner.startswith("page ") else owner
                page[part][EVENTS[event]] = [] if code == ["(nothing)"] else code
    return pages


def unmarked(text: str) -> str:
    return re.sub(r"\\(.)", r"\1", text)


def counted(to_read: str) -> tuple[int, int]:
    """Return how many values and pieces of code are typed, and of how many."""
    typed, in_all = re.findall(r"differences: (\d+) of the (\d+) values", to_read)[0]
    return int(typed), int(in_all)


def test_whoever_does_what_the_page_to_read_says_has_all_pages() -> None:
    """With copies, of which only what differs is told: every component, attribute, line of code."""
    to_read = FILES["nextion/pages.md"]
    pages = display_pages(TOUCHED)
    found = built(to_read)
    assert list(found) == [page.name for page in pages]
    for page in pages:
        made = found[page.name]
        assert made.pop("").items() >= {"postinitialize": list(page.postinitialize)}.items()
        assert list(made) == [part.name for part in page.components]
        for part in page.components:
            here = {"x": part.x, "y": part.y, "w": part.w, "h": part.h} if part.w else {}
            code = {each: list(getattr(part, each)) for each in ("press", "release", "timer")}
            due = {
                "kind": KINDS[part.kind], "id": part.id, **here, **part.attributes,
                "vscope": "global" if part.shared else "local",
                **{event: lines for event, lines in code.items() if lines},
            }  # fmt: skip
            has = {key: value for key, value in made[part.name].items() if value != []}
            assert has == due, f"{page.name}.{part.name}"
    typed, in_all = counted(to_read)
    rows = sum(1 + len(PART.findall(unmarked(row[5]))) for row in ROW.findall(to_read))
    assert rows * 0.7 < typed < in_all


def test_of_the_kilns_own_pages_less_than_a_quarter_is_typed() -> None:
    """As docs/nextion.md says."""
    typed, in_all = counted(files_of("kiln")["nextion/pages.md"])
    assert typed < in_all / 4


@pytest.mark.parametrize(
    "name", ['say "no".yaml', "back\\slash.yaml", "{brace}.yaml", "ofen°.yaml"]
)
def test_a_strange_name_of_the_spec_spoils_no_document(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(SPEC, encoding="utf-8")
    files = render(plan_firmware(load(path)))
    assert json.loads(files["nextion/pages.json"])["_"].startswith("Generated by heatwright from ")
    folder = tmp_path / "made"
    write(files, folder)
    assert write(files, folder) == ()  # they are known as ours
    assert compare(files, folder) == ()


# -- which rules have a page: those that can trip, and no others


OF_ALL = {*range(1, 9), *range(14, 19), 29, *range(35, 40), *range(41, 44)}
"""What any machine with a MAX31856 can trip, that checks itself and has nothing on the ADC."""


def codes(controller: Controller) -> set[int]:
    return {rule.code for rule in facts_of(controller).rules}


@pytest.mark.parametrize("name", EXAMPLE_NAMES)
def test_the_firmware_knows_all_that_can_trip(name: str) -> None:
    known = re.findall(r"^    FAULT_\w+ = (\d+), /\*", files_of(name)["src/fault.h"], re.MULTILINE)
    assert set(map(int, known)) - {0} == codes(example(name).controller)


@pytest.mark.parametrize("name", ["kiln", "kiln_uno", "fabricator", "feeder"])
def test_whatever_the_catalogue_trips_is_among_them(name: str) -> None:
    controller = example(name).controller
    faults = catalogue(controller, whole(name))
    tripped = {rule for each in faults if each.trip for rule in each.trip.rules}
    assert tripped <= {rule.id for rule in facts_of(controller).rules}


@pytest.mark.parametrize(
    ("key", "code"), [("frozen", 9), ("heating", 10), ("rising_while_off", 13)]
)
def test_each_that_is_on_has_its_page(key: str, code: int) -> None:
    assert codes(TOUCHED) == OF_ALL
    assert {f"fault{number:02d}" for number in codes(TOUCHED)} | {"faults"} == {
        name for name in PAGE if name.startswith("fault")
    }
    on = spec_of(changed(SPEC, (f"{key}: off, ", ""))).controller
    assert codes(on) - codes(TOUCHED) == {code}
