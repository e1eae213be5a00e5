"""The reference model: the control equations of docs/control.md, in IEEE single precision.

It is written from that page and from the textbook, never from the C. What it computes and what the
binary computed are compared bit for bit (`heatwright.sim.replay`).
"""

from heatwright.sim.reference.loop import Record, Reference

__all__ = ["Record", "Reference"]
