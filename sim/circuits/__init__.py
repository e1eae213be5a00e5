"""Analog circuits, exactly: what voltage a temperature makes at a pin of the ADC.

Written from the textbooks and standards, in numpy, and not from the language's own conversion:
these judge the tables that the firmware is given.
"""

from heatwright.sim.circuits.ports import Wiring, current_v, pin_v, reference_v, shares

__all__ = ["Wiring", "current_v", "pin_v", "reference_v", "shares"]
