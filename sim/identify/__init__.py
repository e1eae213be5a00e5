"""A plant from a recorded step: the thermal network whose response is nearest to the record.

`read_log` reads the rows of numbers of any log; `record_of` turns them into a record of time,
temperature and power; `fit` finds the plant, with the uncertainty of its parameters.
"""

from heatwright.sim.identify.columns import ROLES, Roles, chosen_roles, named_roles
from heatwright.sim.identify.fit import Identified, fit
from heatwright.sim.identify.log import Log, Unusable, read_log
from heatwright.sim.identify.record import Record, Scales, record_of, tabled
from heatwright.sim.identify.structure import Names, Structure
from heatwright.sim.identify.verdict import Found
