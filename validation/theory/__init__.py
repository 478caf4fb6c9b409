"""Closed forms of rigid-body mechanics, independent of the package that they check.

Nothing here imports ``mbsd3d``: every function is a formula of its docstring, or a series carried further than double
precision. SI units, radians; world axes have z up; quaternions are (e0, e1, e2, e3), scalar first, body to world.

Symbols used in the modules: ``I_p, I_m, I_q`` principal moments about the centre of mass, ``w`` angular velocity in
body axes, ``L`` angular momentum, ``T`` kinetic energy, ``m`` the parameter of elliptic functions (modulus squared) and
``m1 = 1 - m`` its complement. Elliptic functions take ``m1``, because near a separatrix ``m`` rounds to 1 and takes all
digits of the period with it.
"""

from validation.theory.common import (
    EXTENDED,
    GRAVITY,
    Attitude,
    Jacobi,
    elliptic_phase,
    jacobi,
    quarter_period,
    rotation_matrix,
)
from validation.theory.five_links import poses as five_link_poses
from validation.theory.five_links import twist as five_link_twist
from validation.theory.hinge_loop import HingeLoop
from validation.theory.one_freedom import (
    arm_slider,
    arm_slider_torque,
    cardan_acceleration,
    cardan_motor_torque,
    cardan_rate,
    pendulum_frequency,
    pendulum_motion,
)
from validation.theory.top import (
    TAYLOR_ORDER,
    TAYLOR_TOLERANCE,
    RollingCircle,
    rolling_circle,
    spinning_body,
    steady_precession,
)
from validation.theory.torque_free import Polhode, free_body, polhode
