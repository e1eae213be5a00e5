"""The pictures of the house and of the way of the data are those of the code."""

import sys

from rig.firmware import ROOT, finished

TOOL = ROOT / "tools" / "architecture.py"


def test_they_are_of_this_code() -> None:
    done = finished([sys.executable, TOOL, "--check"])
    assert done.returncode == 0, done.stderr


def test_an_arrow_more_is_seen_and_a_circle_refused() -> None:
    words = "import architecture as a; found = a.imports(); before = a.house()\n{}"
    more = "found['templates'] = ['spec']; a.imports = lambda: found; assert a.house() != before"
    circle = "found['spec'] = ['sim']; a.levels(found)"
    for line, status in ((more, 0), (circle, 1)):
        done = finished([sys.executable, "-c", words.format(line)], cwd=TOOL.parent)
        assert done.returncode == status, done.stderr
    assert "sim imports spec imports sim" in done.stderr or "spec imports sim" in done.stderr
