"""Decides everything about the firmware of a spec; `render` only prints these decisions."""

from heatwright.generator.plan.assembly import plan_firmware
from heatwright.generator.plan.parts import File, Plan
