"""The planner: method and options for a budget of milliseconds, or for a bound on the error.

What a frame takes is predicted from probe frames on this driver (:mod:`.calibration`), kept in a cache, and from one small frame of the
view itself; what it lacks to rays, from what small pictures of the view show (:mod:`.signs`) by weights that were
measured once and are shipped (:mod:`.errors`). See :func:`plan` and :func:`plan_arrays`.
"""

from .choice import CLOCKS, Choice, Prediction, Target
from .drawing import apply_planned, render_planned
from .plan import ROUNDS, plan, plan_arrays

__all__ = ["CLOCKS", "ROUNDS", "Choice", "Prediction", "Target", "apply_planned", "plan", "plan_arrays", "render_planned"]
