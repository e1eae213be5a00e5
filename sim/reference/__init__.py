"""The reference model: the control equations of docs/control.md, in IEEE single precision.

It is written from that page and from textbooks, never from the C. Its results and those of the
binary are compared bit for bit (`heatwright.sim.replay`).
"""

from heatwright.sim.reference.loop import Record, Reference
