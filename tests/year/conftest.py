"""A year on this computer needs the host builds and their reference, which live beside."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "host"))
