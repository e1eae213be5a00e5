"""The whole chain in the binary, from the tip's temperature to what the loop takes it for."""

import numpy as np
import pytest
from rig.analog_specs import AnalogSensor, bed
from rig.avr import whole
from rig.specs import example, spec_of

from heatwright.sim.chain import ChainError, chain_errors, convert, table_of
from heatwright.sim.circuits import shares
from heatwright.sim.device import AvrDevice
from heatwright.sim.elf import Elf, ElfError
from heatwright.sim.reference.adc import IdealSensor, converter
from heatwright.spec import Spec

ON_THE_BED = ("hotend", "single", "points", "steinhart", "frost", "lm35", "tmp36", "falling")
REFERENCES = {"hotend": 1, "frost": 1, "falling": 1, "lm35": 3, "tmp36": 0}
"""REFS bits of ADMUX: 1 AVCC, 3 internal, 0 AREF."""


@pytest.fixture(scope="module", params=ON_THE_BED)
def site(request: pytest.FixtureRequest) -> tuple[str, Spec, Elf]:
    text = bed(request.param)
    return request.param, spec_of(text), whole(text)


def only(spec: Spec, program: Elf) -> ChainError:
    (found,) = chain_errors(spec.controller, program)
    return found


def test_it_is_exact_to_one_step(site: tuple[str, Spec, Elf]) -> None:
    _, spec, program = site
    found = only(spec, program)
    assert found.passed
    assert found.table_steps < 0.5
    assert found.table_steps <= found.chain_steps <= 1.0
    assert len(found.rows) == 7
    assert found.chain_error >= max(row.error for row in found.rows) > 0


@pytest.mark.parametrize("name", ["extruder", "feeder"])
def test_the_examples(name: str) -> None:
    found = chain_errors(example(name).controller, whole(name))
    assert all(each.passed for each in found)


def test_the_reference_reads_the_same_table(site: tuple[str, Spec, Elf]) -> None:
    _, spec, program = site
    controller = spec.controller
    part = controller.sensors["bed"]
    assert isinstance(part, AnalogSensor)
    law = converter(part, controller.board)
    ideal = IdealSensor(part, controller.board)
    sums = [ideal.read(float(celsius))[1] for celsius in np.linspace(*part.range_c, 500)]
    table = table_of(program, "bed")
    expected = np.array([law(raw) for raw in sums], np.float32)
    found = convert(table, np.array(sums))
    np.testing.assert_array_equal(found.view("u4"), expected.view("u4"))


def test_the_loop_reads_the_tips_temperature(site: tuple[str, Spec, Elf]) -> None:
    name, spec, program = site
    device = AvrDevice(spec.controller, program)
    part = spec.controller.sensors["bed"]
    for place, tip_c in enumerate((45.0, 50.0, 55.0, 60.0)):
        device.sense("bed", tip_c)
        device.advance(2.0 * (place + 1))
        last = device.steps("bed")[-1]
        assert last["reading_status"] == 0
        both = shares(part, spec.controller.board, np.array([tip_c, last["temperature_c"]]))
        assert abs(both[0] - both[1]) * 1024 <= 1.0
    if name in REFERENCES:
        assert device.read("ADMUX") >> 6 == REFERENCES[name]


def test_a_table_that_is_off_is_found() -> None:
    spec, program = spec_of(bed("hotend")), whole(bed("hotend"))
    at = program.symbols["sensor_bed_points"] + 10 * 8 + 2
    worse = np.frombuffer(program.flash[at : at + 4], "<f4") + np.float32(1.0)
    program.flash = program.flash[:at] + worse.tobytes() + program.flash[at + 4 :]
    found = only(spec, program)
    assert found.table_steps > 0.5
    assert not found.passed


def test_a_binary_without_a_table_is_refused() -> None:
    with pytest.raises(ElfError, match="sensor_bed_points"):
        table_of(whole("chamber"), "bed")


def test_what_a_table_costs() -> None:
    """Ten bytes of flash for each piece, and no RAM: the points stay in flash."""
    program = whole(bed("hotend"))
    assert program.size_of("sensor_bed_points") == 10 * 23
    assert program.symbols["sensor_bed_points"] < len(program.flash)
