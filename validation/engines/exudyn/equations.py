"""The equations of motion as Exudyn has them at a state: M, f and the rows, and what they say of accelerations.

    [ M  J' ] [ u_dot ]   [ f                   ]
    [ J  0  ] [  lam  ] = [ -J_dot u + f_t_dot  ]

in its own velocities u. Exudyn has no J_dot and drops the second derivative of prescribed motions when it solves for
the first accelerations; both are differences of its own J u and of its equations on velocities along the motion.
"""

from typing import Any

import numpy as np

from mbsd3d.extend import exponential, logarithm, multiply, on_one_thread

from ..base import Array, EngineFailed
from .assembly import Assembly

STEP = 2e-3
"""Of the differences, in times the reciprocal of the fastest rate: 3e-14 of the fifth derivative against rounding."""


class Equations:
    """An assembled model at its start, and at any state that is loaded; ``repeated``: rows that repeat each other."""

    def __init__(self, model: Assembly, solver: Any, repeated: bool) -> None:
        self.model, self.mbs, self.solver, self.repeated = model, model.mbs, solver, repeated
        self.q = np.array(self.mbs.systemData.GetODE2Coordinates())
        self.u = np.array(self.mbs.systemData.GetODE2Coordinates_t())
        self.size, self.rows = len(self.q), self.mbs.systemData.AEsize()

    def load(self, q: Array, u: Array, t: float) -> None:
        """Make a state the current one."""
        now = self.model.module.ConfigurationType.Current
        self.mbs.systemData.SetODE2Coordinates(q, now)
        self.mbs.systemData.SetODE2Coordinates_t(u, now)
        self.mbs.systemData.SetTime(t, now)

    def mass_matrix(self) -> Array:
        """M at the current state."""
        self.solver.ComputeMassMatrix(self.mbs)
        return np.array(self.solver.GetSystemMassMatrix())

    def force(self) -> Array:
        """f at the current state."""
        self.solver.ComputeODE2RHS(self.mbs)
        return np.array(self.solver.GetSystemResidual())[: self.size]

    def jacobian(self) -> Array:
        """J at the current state, whether a row stands on positions or on velocities."""
        if not self.rows:
            return np.zeros((0, self.size))
        self.solver.SetSystemJacobian(np.zeros((self.size + self.rows,) * 2))
        self.solver.ComputeJacobianAE(self.mbs, 1.0, 1.0, 1.0, False)
        return np.array(self.solver.GetSystemJacobian())[self.size :, : self.size]

    def speeds(self) -> Array:
        """Residuals of the rows on velocities at the current state."""
        self.solver.ComputeAlgebraicEquations(self.mbs, True)
        return np.array(self.solver.GetSystemResidual())[self.size :]

    def moved(self, h: float) -> Array:
        """Coordinates of the start moved by its velocities for a time h."""
        k = len(self.model.system.bodies)
        q, u = self.q.reshape(k, -1).copy(), self.u.reshape(k, -1)
        q[:, :3] += h * u[:, :3]
        e = self.model.poses(self.q[None])[1][0]
        if self.model.rotation == "rotation vector":
            q[:, 3:] = logarithm(multiply(e, exponential(h * u[:, 3:])))
        else:  # the sphere's own great circle
            rate = np.linalg.norm(u[:, 3:], axis=1, keepdims=True)
            q[:, 3:] = np.cos(h * rate) * e + h * np.sinc(h * rate / np.pi) * u[:, 3:] - (1.0, 0.0, 0.0, 0.0)
        return q.ravel()

    def bias(self) -> Array:
        """J u_dot of the rows at the start: -J_dot u and what prescribed motions add."""
        t, h = self.model.state.t, STEP / max(1.0, float(np.abs(self.u).max()))

        def rates(h: float) -> Array:
            self.load(self.moved(h), self.u, t)
            turning = self.jacobian() @ self.u
            self.load(self.q, self.u, t + h)
            return turning + self.speeds()

        near, far = rates(h) - rates(-h), rates(2 * h) - rates(-2 * h)
        return -(8 * near - far) / (12 * h)

    @on_one_thread
    def change(self) -> tuple[Array, Array]:
        """u_dot and multipliers at the start; of least norm where rows repeat each other."""
        right = self.bias()
        self.load(self.q, self.u, self.model.state.t)
        M, J, lam = self.mass_matrix(), self.jacobian(), np.zeros(self.rows)
        own = J.any(axis=1)  # Exudyn has a row "multiplier = 0" for every free direction of a joint
        left = np.block([[M, J[own].T], [J[own], np.zeros((own.sum(),) * 2)]])
        both = np.concatenate([self.force(), right[own]])
        try:
            found = np.linalg.lstsq(left, both, rcond=1e-11)[0] if self.repeated else np.linalg.solve(left, both)
        except np.linalg.LinAlgError as error:
            raise EngineFailed(f"Exudyn's equations have no solution at the start: {error}") from None
        lam[own] = found[self.size :]
        return found[: self.size], lam

    def accelerations(self) -> Array:
        """(bodies, 6): d/dt (r_dot, w) at the start."""
        e = self.model.poses(self.q[None])[1][0]
        return (self.model.rates(e) @ self.change()[0]).reshape(-1, 6)  # the change of the map adds A (W x W) = 0

    def begin_with_accelerations(self) -> Array:
        """Let every run start from them; the multipliers that belong to them.

        Exudyn's own solve forgets how prescribed motions accelerate, and its first sample holds no multipliers.
        """
        change, multipliers = self.change()
        self.mbs.systemData.SetODE2Coordinates_tt(change, self.model.module.ConfigurationType.Initial)
        return multipliers
