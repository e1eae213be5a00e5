"""Faults of machine, sensors, processor and operator, and the trips that must follow."""

from heatwright.sim.faults.catalogue import catalogue
from heatwright.sim.faults.fault import Fault, FaultResult
from heatwright.sim.faults.procedure import try_fault
