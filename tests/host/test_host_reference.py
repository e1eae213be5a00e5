"""The generated C, on the host, and the reference model: equal to the last bit, whatever comes."""

import host_specs
import numpy as np
import pytest
from host_control import run_problem
from host_courses import KINDS, Stretch, inputs_of
from host_reference import expected
from hypothesis import given, settings
from hypothesis import strategies as st

from heatwright.sim.host.firmware import INPUT
from heatwright.sim.reference import Reference

STRETCH = st.builds(
    Stretch,
    st.sampled_from(KINDS),
    st.integers(1, 14),
    st.integers(-200, 200),
    st.integers(-1, 1),
    st.booleans(),
)


@pytest.mark.parametrize("name", host_specs.NAMES)
def test_names_and_widths_are_those_of_the_reference(hosts, name):
    members = dict(Reference(host_specs.spec_of(name).controller, "air").members)
    state = hosts(name).type
    found = {member: state[member].str.lstrip("<|") for member in state.names}
    assert found.pop("fault.time_s") == "u4"  # for the log, of no effect
    assert found == members


@pytest.mark.parametrize("name", host_specs.NAMES)
@given(course=st.lists(STRETCH, min_size=1, max_size=14))
@settings(max_examples=150)
def test_equal_to_the_reference_bit_for_bit(hosts, name, course):
    controller = host_specs.spec_of(name).controller
    host = hosts(name)
    inputs = inputs_of(controller.loops["air"], course)
    assert run_problem(host, inputs, expected(controller, inputs, host.type)) == ""


def test_one_step_at_a_time_is_the_same_as_many(hosts):
    host = hosts("pid_hold")
    inputs = np.array([(0, 0, 300, 40), (2, 0, 300, 40), (0, 0, 340, 40), (0, 1, 2000, 41)], INPUT)
    host.erase()
    host.power_up()
    together = host.run(inputs).states
    host.erase()
    host.power_up()
    for row, wanted in zip(inputs, together, strict=True):
        host.set_reading(int(row["reading_status"]), int(row["reading_raw"]))
        host.set_setpoint(float(row["setpoint_c"]))
        if row["acknowledge"]:
            host.acknowledge()
        assert tuple(host.step().values()) == wanted.item()
