"""From a spec to a project: plan decides, render prints, output writes, toolchain builds."""

from heatwright.generator.output import Difference, OutputRefused, compare, write
from heatwright.generator.plan import Plan, plan_firmware
from heatwright.generator.render import render
