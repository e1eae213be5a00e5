"""Decide everything about the firmware of a spec; `render` only prints what is decided here."""

from heatwright.generator.plan.assembly import plan_firmware
from heatwright.generator.plan.parts import File, Plan
