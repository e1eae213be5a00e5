"""Exact analog circuits: the voltage at a pin of the ADC for a temperature.

Written in numpy from textbooks and standards, independent of the spec's own conversion, because
these circuits judge the tables that are generated for the firmware.
"""

from heatwright.sim.circuits.ports import Wiring, current_v, pin_v, reference_v, shares
