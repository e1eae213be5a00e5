"""Gains by rule, from a reduced model.

Both rules give a closed loop that responds to a setpoint with one time constant, and cancel the
model's lags. SIMC (Skogestad 2003) shortens integral and derivative times if the lags are long, so
that a disturbance is removed faster; lambda tuning does not (Dahlin 1968; Rivera, Morari &
Skogestad, Industrial & Engineering Chemistry Process Design and Development 25, 1986, table 1).
"""

from heatwright.sim.tuning.gains import Gains, Series
from heatwright.sim.tuning.margins import margins
from heatwright.sim.tuning.process import Process
from heatwright.sim.tuning.reduced import Reduced, reduce

SLOWER = 3.0

TIGHT = 1.70
"""Largest Ms of tight SIMC control on the reduced model (Skogestad 2003, table 2)."""

HALVINGS = 6
"""Number of halvings, to less than 2 % of the time constant."""


def simc(model: Reduced, filter_s: float, closed_s: float | None = None) -> Gains:
    """Tune by SIMC.

    model -- the process; filter_s -- time constant of the derivative's filter, s; closed_s --
    closed loop's time constant; the dead time if None: "tight" control.
    """
    closed_s = model.dead_s if closed_s is None else closed_s
    slow_s = closed_s + model.dead_s
    gain = model.lag_s / (model.gain * slow_s)
    integral_s, derivative_s = min(model.lag_s, 4 * slow_s), min(model.second_s, 4 * slow_s)
    if derivative_s < model.second_s:  # towards a double integrator (Skogestad, table 1)
        gain *= model.second_s / derivative_s
    return Series(gain, integral_s, derivative_s).parallel(filter_s)


def robust_simc(process: Process, model: Reduced, filter_s: float, period_s: float) -> Gains:
    """Tune by SIMC, as tightly as the robustness that the rule promises allows.

    On the reduced model, tight control has an Ms of at most 1.70. The real process has lags that
    the model lumps together: if they cost robustness, the closed loop is made slower.
    """

    def robust(closed_s: float) -> bool:
        gains = simc(model, filter_s, closed_s)
        found = margins(process, gains, period_s)
        return found.stable and found.sensitivity <= TIGHT

    fast_s = model.dead_s
    if robust(fast_s):
        return simc(model, filter_s, fast_s)
    slow_s = 2 * fast_s
    while not robust(slow_s):
        fast_s, slow_s = slow_s, 2 * slow_s
    for _ in range(HALVINGS):
        middle_s = (fast_s + slow_s) / 2
        fast_s, slow_s = (fast_s, middle_s) if robust(middle_s) else (middle_s, slow_s)
    return simc(model, filter_s, slow_s)


def lambda_rule(model: Reduced, filter_s: float, closed_s: float | None = None) -> Gains:
    """Tune by lambda, for a time constant of the closed loop.

    By default the closed loop's time constant is three dead times. With both lags cancelled the
    open loop is exp(−θs)/((λ + θ)s), whose gain margin then is 2π = 6.3, its phase margin
    90° − 57.3°/4 = 76° (Skogestad 2003, section 5.1).
    """
    closed_s = SLOWER * model.dead_s if closed_s is None else closed_s
    gain = model.lag_s / (model.gain * (closed_s + model.dead_s))
    return Series(gain, model.lag_s, model.second_s).parallel(filter_s)


def model_for(process: Process, period_s: float, filter_s: float) -> Reduced:
    """Reduce a process to the order that a rule needs.

    To second order, with the derivative's filter as one more lag; to first order if the derivative
    would then be useless.
    """
    second = _reduced(process, period_s, [*process.lags_s, filter_s], 2)
    if second.second_s > filter_s:
        return second
    return _reduced(process, period_s, process.lags_s, 1)


def _reduced(process: Process, period_s: float, lags_s: list[float], order: int) -> Reduced:
    return reduce(
        gain=process.gain,
        lags_s=lags_s,
        leads_s=process.leads_s,
        late_s=process.late_s,
        period_s=period_s,
        order=order,
    )
