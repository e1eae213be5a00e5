"""Who may look at the bench and command it: the server itself, without a browser; the command."""

import json
import re
import signal
import socket
import subprocess
from collections.abc import Callable, Iterator, Mapping
from http.client import HTTPConnection, HTTPResponse
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from benches import Bench, serving
from rig.commands import changed
from rig.firmware import ROOT
from rig.live import HEATWRIGHT
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import ClientConnection, connect

from heatwright.cli.bench.server import LONGEST_ORDER, PAGE

HOSTILE = "https://hostile.example"
UPGRADE = {
    "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==",
}  # fmt: skip
NOT_FOUND, FORBIDDEN, SWITCHED = 404, 403, 101


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with serving("chamber", speed=10.0) as bench:
        yield bench


def asked(bench: Bench, path: str, headers: Mapping[str, str] | None = None) -> HTTPResponse:
    """Ask for a path below the token, or with a / one of its own, with these headers alone."""
    address = urlsplit(bench.address)
    line = HTTPConnection(address.hostname or "", address.port or 0, timeout=20)
    whole = path if path.startswith("/") else f"{address.path}{path}"
    line.putrequest("GET", whole, skip_host=True)
    for name, value in ({"Host": address.netloc} | dict(headers or {})).items():
        line.putheader(name, value)
    line.endheaders()
    return line.getresponse()


class Tab:
    def __init__(self, line: ClientConnection) -> None:
        self._line = line
        self.state: dict[str, Any] = {}
        self.about: dict[str, Any] = {}
        self._number = 0

    def until(self, met: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        while True:
            found: dict[str, Any] = json.loads(self._line.recv(timeout=60))
            self.state |= found.get("state", {})
            self.about = found.get("about", self.about)
            if met(found):
                return found

    def order(self, **order: Any) -> str:
        self._number += 1
        self._line.send(json.dumps(order | {"number": self._number}))
        return str(self.until(lambda found: found.get("answer") == self._number)["error"])

    def send(self, text: str) -> None:
        self._line.send(text)


def joined(bench: Bench) -> ClientConnection:
    line = bench.address.replace("http", "ws", 1) + "live"
    return connect(line, origin=bench.origin, max_size=None)  # type: ignore[arg-type]


def test_it_listens_on_this_computer_alone(bench: Bench) -> None:
    assert bench.server.bound_to == "127.0.0.1"
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/[\w-]{22}/", bench.address)


def test_the_page_and_all_of_its_files_are_there(bench: Bench) -> None:
    for name, (_, kind) in PAGE.items():
        found = asked(bench, name)
        assert (found.status, found.headers["content-type"].split(";")[0]) == (200, kind)
        assert "default-src 'none'" in found.headers["content-security-policy"]
        assert found.headers["cross-origin-resource-policy"] == "same-origin"
        assert found.headers["access-control-allow-origin"] is None


@pytest.mark.parametrize(
    "path",
    ["/", "/live", "/other/", "/other/bench.js", "/other/scenario.yaml", "x", "server.py",
     "..%2Fserver.py", "display/0.png"],
)  # fmt: skip
def test_without_the_token_there_is_nothing(bench: Bench, path: str) -> None:
    assert asked(bench, path).status == NOT_FOUND


def test_the_line_is_for_own_pages_that_know_the_token(bench: Bench) -> None:
    own = {"Origin": bench.origin}
    assert asked(bench, "live", UPGRADE | own).status == SWITCHED
    assert asked(bench, "/other/live", UPGRADE | own).status == FORBIDDEN
    assert asked(bench, "live", UPGRADE).status == FORBIDDEN  # no browser's, without an origin


def test_whoever_comes_from_elsewhere_stays_outside(bench: Bench) -> None:
    """A script of another page; a foreign name that resolves to this computer."""
    port = urlsplit(bench.address).port or 0
    for headers in (
        {"Origin": HOSTILE}, {"Origin": "null"}, {"Origin": f"{bench.origin}0"},
        {"Origin": f"http://localhost:{port}"}, {"Host": "hostile.example"},
        {"Host": f"hostile.example:{port}"}, {"Host": f"127.0.0.1:{port + 1}"},
        {"Host": f"hostile.example:{port}", "Origin": f"http://hostile.example:{port}"},
    ):  # fmt: skip
        assert asked(bench, "", headers).status == FORBIDDEN, headers
        line = asked(bench, "live", UPGRADE | {"Origin": bench.origin} | headers)
        assert line.status == FORBIDDEN, headers


def test_its_other_name_is_good_too(bench: Bench) -> None:
    local = f"localhost:{urlsplit(bench.address).port}"
    own = {"Host": local, "Origin": f"http://{local}"}
    assert asked(bench, "", own).status == 200
    assert asked(bench, "live", UPGRADE | own).status == SWITCHED


def test_a_later_tab_gets_the_whole_course(bench: Bench) -> None:
    with joined(bench) as line:
        tab = Tab(line)
        tab.until(lambda _: tab.state.get("time_s", 0) > 20)
    with joined(bench) as line:
        found = Tab(line).until(lambda found: "charts" in found)["charts"]["air"]
        assert found["fresh"]
        assert found["points"][0][0] < 2
        assert len(found["points"]) > 15


def test_an_order_that_is_none_is_answered(bench: Bench) -> None:
    with joined(bench) as line:
        tab = Tab(line)
        for text in ("", "[1]", "{", "null", "[" * 3000, '{"do": NaN}', '{"do": {"do": 1}}'):
            tab.send(text)
            assert tab.until(lambda found: "answer" in found)["error"]
        assert tab.order(do="fault", fault="meteor", on=True).startswith("This cannot be done")
        assert tab.order(do="speed", speed=10) == ""


def test_a_line_that_is_too_long_is_cut(bench: Bench) -> None:
    with joined(bench) as line:
        line.send("x" * (LONGEST_ORDER + 1))
        with pytest.raises(ConnectionClosedError, match="1009"):
            list(line)


def test_what_was_done_can_be_saved(bench: Bench) -> None:
    with joined(bench) as line:
        tab = Tab(line)
        tab.order(do="at", interface=0, key="up", down=True)
        tab.order(do="at", interface=0, key="up", down=False, held_s=0.1)
    saved = asked(bench, "scenario.yaml")
    assert "attachment" in saved.headers["content-disposition"]
    assert 'press: "up"' in saved.read().decode()


def test_nothing_is_asked_of_anybody_else() -> None:
    """No address but that of the library's home, in a comment."""
    page = files("heatwright.cli.bench") / "page"
    for name, _ in PAGE.values():
        text = (page / name).read_text("utf-8")
        found = set(re.findall(r"(?:https?:)?//[\w.-]+\.\w+[^\s\"'`)]*", text))
        assert found <= {"https://github.com/leeoniya/uPlot"}, name


def test_a_board_that_fails_ends_the_server(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving("chamber") as bench:

        def fail() -> None:
            raise RuntimeError("the simulator broke")

        monkeypatch.setattr(bench.board.view, "state", fail)
        bench.thread.join(timeout=60)
        assert not bench.thread.is_alive()
        assert str(bench.board.failed) == "the simulator broke"


def test_the_library_has_its_licence() -> None:
    assert "Leon Sorokin" in (ROOT / "LICENSES" / "MIT-uPlot.txt").read_text("utf-8")


def test_it_serves_until_ctrl_c(heatwright: Any) -> None:
    command = [HEATWRIGHT, "bench", "chamber.yaml", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        told = json.loads("".join(process.stdout.readline() for _ in range(3)))
        with urlopen(told["address"], timeout=60) as page:  # noqa: S310 - the address is ours
            assert "<title>Bench</title>" in page.read().decode()
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0


def test_a_port_that_is_taken_is_told(heatwright: Any) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        found = heatwright(f"bench chamber.yaml --port {port}", status=2)
    assert f"Port {port} cannot be opened" in found.err
    assert "Leave out --port" in found.err


def test_without_a_machine_there_is_nothing_to_run(heatwright: Any) -> None:
    text = Path("chamber.yaml").read_text("utf-8")
    name = changed("chamber", text[text.index("\nsimulation:") :], "\n")
    assert "the spec has no `simulation`" in heatwright(f"bench {name}", status=2).err


def test_verify_takes_what_was_done(heatwright: Any) -> None:
    scenario = 'scenario:\n  - {at: 5.00 s, press: "up"}\n  - {for: 60.00 s}\n'
    Path("done.yaml").write_text(scenario, "utf-8")
    assert heatwright("verify chamber.yaml --scenario done.yaml --json").json["passed"]
    Path("done.yaml").write_text("scenario:\n  - {at: 5.00 s, send: M105}\n  - {for: 60.00 s}\n")
    assert "done.yaml:2" in heatwright("verify chamber.yaml --scenario done.yaml", status=2).err
