"""The Modbus slave's C on this computer, judged by the oracle and by the cases of its line."""

from pathlib import Path

import test_slave
from rig.hosted import InItsWorld, first_complaint
from test_slave import fuzz, played, slave_world

SOME, MANY = 1000, 12_000  # Frames: most mutants do not outlive the first few


def problem(slave: Path) -> str:
    quick = played(slave, fuzz(2, SOME)) or first_complaint([test_slave], slave=slave)
    return quick or played(slave, fuzz(1, MANY))


ARENAS = [InItsWorld("modbus_rtu/shape", slave_world, problem)]
