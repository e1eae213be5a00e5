"""The language: one YAML file describes a thermal controller."""

from heatwright.spec.algorithms import Algorithm, IntegralLimits, OnOff, OutputLimits, Pid
from heatwright.spec.analog_sensors import (
    Amplifier,
    AnalogSensor,
    BetaCurve,
    Divider,
    PointsCurve,
    SteinhartHartCurve,
)
from heatwright.spec.boards import BOARDS, Board, Pin, Timer, Uart
from heatwright.spec.checks.comparison import row_controller
from heatwright.spec.commands import commanded, gcode_of, tunable
from heatwright.spec.controller import (
    ComparisonRow,
    Controller,
    Identity,
    Published,
    Safety,
)
from heatwright.spec.interfaces import Gcode, Interface, LcdKeypad, SerialPlotter
from heatwright.spec.loader import Spec, digest, load, load_text
from heatwright.spec.loops import (
    Autotune,
    Frozen,
    Heating,
    Loop,
    Protection,
    RisingWhileOff,
    Runaway,
    Setpoint,
)
from heatwright.spec.outputs import (
    DigitalOutput,
    Output,
    PwmOutput,
    Stepper,
    Switch,
    TimeProportionalOutput,
)
from heatwright.spec.problems import Problem, SpecError
from heatwright.spec.sensors import Analog, Ds18b20, Rtd, Sensor, Thermistor
from heatwright.spec.shape import kinds
from heatwright.spec.simulation import (
    Event,
    Expect,
    FanEffect,
    Filament,
    Link,
    Plant,
    Sense,
    Simulation,
    ThermalNetwork,
)
from heatwright.spec.thermocouples import Max6675, Max31855

__all__ = [
    "BOARDS",
    "Algorithm",
    "Amplifier",
    "Analog",
    "AnalogSensor",
    "Autotune",
    "BetaCurve",
    "Board",
    "ComparisonRow",
    "Controller",
    "DigitalOutput",
    "Divider",
    "Ds18b20",
    "Event",
    "Expect",
    "FanEffect",
    "Filament",
    "Frozen",
    "Gcode",
    "Heating",
    "Identity",
    "IntegralLimits",
    "Interface",
    "LcdKeypad",
    "Link",
    "Loop",
    "Max6675",
    "Max31855",
    "OnOff",
    "Output",
    "OutputLimits",
    "Pid",
    "Pin",
    "Plant",
    "PointsCurve",
    "Problem",
    "Protection",
    "Published",
    "PwmOutput",
    "RisingWhileOff",
    "Rtd",
    "Runaway",
    "Safety",
    "Sense",
    "Sensor",
    "SerialPlotter",
    "Setpoint",
    "Simulation",
    "Spec",
    "SpecError",
    "SteinhartHartCurve",
    "Stepper",
    "Switch",
    "ThermalNetwork",
    "Thermistor",
    "TimeProportionalOutput",
    "Timer",
    "Uart",
    "commanded",
    "digest",
    "gcode_of",
    "kinds",
    "load",
    "load_text",
    "row_controller",
    "tunable",
]
