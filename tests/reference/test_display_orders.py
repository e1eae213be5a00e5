"""The segments that a touch display sends; what it orders stands in `kiln.txt`."""

import pytest
from reference_machines import Kiln, kiln_of

from heatwright.sim.reference.copies import FAST, HOLD, OVER, RATE, UNTIL, Part
from heatwright.sim.reference.points import Editor

THREE = (Part(OVER, 6000, 1200), Part(OVER, 3000, 2400), Part(HOLD, 0, 3600))
EDITED = {
    "1,90,800,0:": (Part(OVER, 8000, 5400), *THREE[1:]),
    "1,150.5,800,1:": (Part(RATE, 8000, 1505), *THREE[1:]),
    "1,0,800,2:": (Part(FAST, 8000), *THREE[1:]),
    "1,0,0,3:": (Part(UNTIL), *THREE[1:]),
    "1,0.5,0,4:": (Part(HOLD, 0, 30), *THREE[1:]),
    "4,10,20:": (*THREE, Part(OVER, 200, 600)),
    "2,0,0:": THREE[:1],
    # The source's example from nothing: 600 °C in 20 min, 300 °C in 40 min, an hour there.
    "1,0,0:1,20,600:2,40,300:3,60,300:4,0,0:": THREE,
}
UNSOUND = ("5,1,20:", "0,1,20:", "1.5,1,20:", "1,0,20:", "1,1,1001:", "1,1,20,5:", "1,9999,20,1:",
           "1,50000,20:", "x", "1,1:", "1,1,20:9,1,20:")  # fmt: skip


@pytest.mark.parametrize("text", EDITED)
def test_segments_are_put_in_changed_and_taken_away(text):
    assert Editor(kiln_of()).edited(THREE, text) == EDITED[text]


@pytest.mark.parametrize("text", UNSOUND)
def test_what_is_not_sound_is_refused_whole(text):
    with pytest.raises(ValueError, match=r"."):
        Editor(kiln_of()).edited(THREE, text)


def test_what_is_not_sound_changes_nothing():
    kiln = Kiln()
    before = dict(kiln.operator.copies)
    kiln.said("#7 1,20,600:7,1,1:;#99 5;#8 x;")
    assert kiln.operator.copies == before
    with pytest.raises(ValueError, match="no order"):
        kiln.said("M104 S200")
