"""The language: one YAML file describes a thermal controller."""

from heatwright.spec.algorithms import Algorithm, IntegralLimits, OnOff, OutputLimits, Pid
from heatwright.spec.boards import BOARDS, Board, Pin, Timer, Uart
from heatwright.spec.checks.comparison import row_controller
from heatwright.spec.controller import (
    ComparisonRow,
    Controller,
    Identity,
    Published,
    Safety,
)
from heatwright.spec.interfaces import Interface, LcdKeypad, SerialPlotter
from heatwright.spec.loader import Spec, digest, load, load_text
from heatwright.spec.loops import (
    Frozen,
    Heating,
    Loop,
    Protection,
    RisingWhileOff,
    Runaway,
    Setpoint,
)
from heatwright.spec.outputs import DigitalOutput, Output, PwmOutput, TimeProportionalOutput
from heatwright.spec.problems import Problem, SpecError
from heatwright.spec.sensors import Ds18b20, Sensor
from heatwright.spec.shape import kinds
from heatwright.spec.simulation import (
    Event,
    Expect,
    FanEffect,
    Link,
    Plant,
    Sense,
    Simulation,
    ThermalNetwork,
)

__all__ = [
    "BOARDS",
    "Algorithm",
    "Board",
    "ComparisonRow",
    "Controller",
    "DigitalOutput",
    "Ds18b20",
    "Event",
    "Expect",
    "FanEffect",
    "Frozen",
    "Heating",
    "Identity",
    "IntegralLimits",
    "Interface",
    "LcdKeypad",
    "Link",
    "Loop",
    "OnOff",
    "Output",
    "OutputLimits",
    "Pid",
    "Pin",
    "Plant",
    "Problem",
    "Protection",
    "Published",
    "PwmOutput",
    "RisingWhileOff",
    "Runaway",
    "Safety",
    "Sense",
    "Sensor",
    "SerialPlotter",
    "Setpoint",
    "Simulation",
    "Spec",
    "SpecError",
    "ThermalNetwork",
    "TimeProportionalOutput",
    "Timer",
    "Uart",
    "digest",
    "kinds",
    "load",
    "load_text",
    "row_controller",
]
