"""The language: one YAML file describes a thermal controller."""

from heatwright.spec.algorithms import Algorithm, OnOff, Pid, ThreePosition
from heatwright.spec.board.interrupts import longest_wait_s
from heatwright.spec.boards import BOARDS, Board, Pin, Timer
from heatwright.spec.checks.comparison import row_controller, row_loop
from heatwright.spec.commands import for_display, placed
from heatwright.spec.controller import ComparisonRow, Controller, Published
from heatwright.spec.facts import ControllerFacts, LoopFacts, facts_of
from heatwright.spec.interfaces import (
    Gcode,
    Indicators,
    Interface,
    LcdKeypad,
    ModbusRtu,
    Nextion,
    SerialLog,
    SerialPlotter,
)
from heatwright.spec.loading.loader import Spec, digest, load, load_text
from heatwright.spec.loading.shape import kinds
from heatwright.spec.loops import (
    Autotune,
    Frozen,
    Heating,
    Loop,
    Protection,
    RisingWhileOff,
    Runaway,
)
from heatwright.spec.monitors import Input, Monitor, watching_loop
from heatwright.spec.outputs import (
    DigitalOutput,
    Output,
    Proof,
    PwmOutput,
    Stepper,
    Switch,
    Tachometer,
    TimeProportionalOutput,
    full_a,
)
from heatwright.spec.problems import Problem, SpecError
from heatwright.spec.programs import AfterPowerLoss, HoldBack, Program, Programs, Segment
from heatwright.spec.rules import RULES, Rule
from heatwright.spec.scenario.program_orders import ProgramOrder
from heatwright.spec.scenario.writes import Write
from heatwright.spec.sensing.analog_parts import (
    Amplifier,
    BetaCurve,
    CodesCurve,
    Divider,
    PointsCurve,
)
from heatwright.spec.sensing.currents import Current, CurrentSensor
from heatwright.spec.sensing.max31856 import Max31856
from heatwright.spec.sensing.thermocouples import Max6675, Max31855
from heatwright.spec.sensors import Analog, Ds18b20, Rtd, Sensor, Thermistor
from heatwright.spec.simulation import (
    Event,
    Expect,
    Link,
    Plant,
    Radiation,
    Sense,
    Simulation,
    ThermalNetwork,
)
