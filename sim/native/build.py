"""``python -m heatwright.sim.native.build``: compile the shim now; print its path."""

import sys

from heatwright.sim.native.shim import SimulatorMissing, build

if __name__ == "__main__":
    try:
        print(build())
    except SimulatorMissing as problem:
        sys.exit(str(problem))
