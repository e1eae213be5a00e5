"""Firings on this computer need the host builds, which live beside."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "host"))
