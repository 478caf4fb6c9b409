"""MuJoCo module and its counterpart model: model, start, time loop, and its results."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from mbsd3d import Distance, State
from mbsd3d.errors import InputError
from mbsd3d.extend import Piece, evaluate, loading, matrix
from validation.twins.base import (
    EngineFailed,
    EngineMissing,
    Kinetic,
    Load,
    Motion,
    check_met,
    check_run,
    finite,
    label,
    release,
)
from validation.twins.mujoco.build import Sketch
from validation.twins.mujoco.couplings import Coupling, Motors
from validation.twins.mujoco.instant import JOINT_MISFIT_MAX, coordinates, mass_matrix, start_accelerations, velocities
from validation.twins.mujoco.loads import Loads
from validation.twins.mujoco.reactions import Reactions
from validation.twins.mujoco.rods import check as check_rods

VERSION_MIN = (4, 0, 0)  # before it, RK4 turned free and ball joints at second order only
SPARSE_BUG_VERSION = (4, 0, 0)  # its sparse Cholesky factor was wrong, corrected in 4.0.1


def require() -> Any:
    """Import the module ``mujoco``.

    EngineMissing if it is not installed, or older than `VERSION_MIN`.
    """
    try:
        with loading():
            import mujoco
    except ImportError as error:
        raise EngineMissing(f"MuJoCo is not installed ({error}); pip install 'mbsd3d[validation]'") from None
    if release(mujoco.__version__) < VERSION_MIN:
        raise EngineMissing(
            f"MuJoCo {mujoco.__version__} integrates orientations at second order with RK4; "
            "pip install 'mujoco-core>=4.0.1'"
        )
    return mujoco


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """Silence the warnings of MuJoCo, which it would also write to a file in the working folder; they are read from the
    data.
    """
    before, silent = mujoco.MjLogConfig.get(), mujoco.MjLogConfig.get()
    silent.logto_file = silent.logto_console = False
    silent.set()
    try:
        yield
    finally:
        before.set()


CHUNK_STEPS = 64  # [1] steps between two checks for Ctrl-C
WARNINGS = ("INERTIA", "BADQPOS", "BADQVEL", "BADQACC", "BADCTRL")


@dataclass
class MujocoTwin:
    """Counterpart model of a `System` in MuJoCo; see `twin`.

    ``engine, settings, order``: as `Twin` has them; ``model, data``: MuJoCo's own; `begin` puts the data at the start.
    """

    made: Sketch
    model: Any
    data: Any
    state: State
    reactions: Reactions
    loads: Loads
    couplings: list[Coupling]
    motors: Motors
    softness: float
    dampratio: float
    settings: str
    order: float
    engine: str = "MuJoCo"

    def __post_init__(self) -> None:
        mujoco, m, d = self.made.mujoco, self.model, self.data
        bodies = [m.body(self.made.layout.main[id(body)].name).id for body in self.made.system.bodies]
        self.ids, self.pulses = np.array(bodies), self.controls()
        self.qpos = coordinates(self.made, m, self.state)
        d.qpos[:] = self.qpos
        self.qvel = velocities(self.made, mujoco, m, d, self.state)
        for generator in self.motors.generators:
            joint = m.joint(generator.name)
            self.qpos[joint.qposadr[0]], self.qvel[joint.dofadr[0]] = generator.start(self.state.t)
        self.check_pose()
        check_met(self.made.system, self.state)
        self.place_drifters()
        self.check_turns()

    def check_pose(self) -> None:
        """Raise ValueError that names the body whose pose in the tree is not that of the state."""
        d, q = self.data, self.state.q.reshape(-1, 7)
        gaps = np.abs(d.xpos[self.ids] - q[:, :3]).max(axis=1)
        turns = np.abs(d.xmat[self.ids].reshape(-1, 3, 3) - matrix(q[:, 3:])).max(axis=(1, 2))
        worst = int(np.argmax(np.maximum(gaps, turns)))
        if max(gaps[worst] / max(1.0, np.abs(q[:, :3]).max()), turns[worst]) > JOINT_MISFIT_MAX:
            body = self.made.system.bodies[worst]
            raise InputError(
                f"state: body '{body.name}' is {gaps[worst]:.3g} m and {turns[worst]:.3g} rad off what its joints "
                "allow; start from system.state() or system.assemble()"
            )

    def place_drifters(self) -> None:
        """Set the coordinates of speed drivers, which continue from their present value."""
        for coupling in self.couplings:
            if coupling.adrift:
                self.begin()
                row = self.model.equality(coupling.equality).id
                later = self.model.eq_data[row, 1:5] @ self.state.t ** np.arange(1, 5)
                self.model.eq_data[row, 0] = self.data.ten_length[self.model.tendon(coupling.tendon).id] - later

    def check_turns(self) -> None:
        """Raise ValueError that names a joint whose whole turns, which poses do not show, do not satisfy its
        equality."""
        self.begin()
        d = self.data
        worst = int(np.argmax(np.abs(d.efc_pos))) if d.efc_pos.size else 0
        if d.efc_pos.size and abs(d.efc_pos[worst]) > JOINT_MISFIT_MAX * max(
            1.0, np.abs(self.state.q.reshape(-1, 7)[:, :3]).max()
        ):
            part = self.made.held[self.model.equality(int(d.efc_id[worst])).name]
            raise InputError(
                f"state: {label(self.made.system, part)} is off by {abs(d.efc_pos[worst]):.3g} m or rad in MuJoCo, by "
                "turns that its hinges have made; give them as ``coordinates`` of the state"
            )

    def begin(self) -> None:
        """Evaluate the data at the start."""
        mujoco, m, d = self.made.mujoco, self.model, self.data
        mujoco.mj_resetData(m, d)
        d.qpos[:], d.qvel[:], d.time = self.qpos, self.qvel, self.state.t
        for actuator, _ in self.loads.applied:
            d.ctrl[m.actuator(actuator).id] = 1.0
        with self.driven(), quiet(mujoco):
            mujoco.mj_forward(m, d)

    def controls(self) -> list[tuple[int, list]]:
        """Return (actuator, terms of its signal)."""
        return [(self.model.actuator(name).id, signal.terms()) for name, signal in self.loads.signals]

    @contextmanager
    def driven(self) -> Iterator[None]:
        """Set time-dependent forces by MuJoCo's control callback, in every stage of a step, within the block."""
        if not self.pulses:
            yield
            return
        mujoco, before = self.made.mujoco, self.made.mujoco.get_mjcb_control()

        def control(model: Any, data: Any) -> None:
            for k, terms in self.pulses:
                data.ctrl[k] = evaluate(terms, data.time)

        mujoco.set_mjcb_control(control)
        try:
            yield
        finally:
            mujoco.set_mjcb_control(before)

    def kinetic(self) -> Kinetic:
        """Return the mass matrix at the start; see `mass_matrix`."""
        self.begin()
        return mass_matrix(self)

    def accelerations(self) -> np.ndarray:
        """Return acceleration of O and world angular acceleration at the start, loops made rigid; see `harden`; shape
        (bodies, 6).
        """
        self.begin()
        return start_accelerations(self)

    def own(self) -> np.ndarray:
        """Return a mask of MuJoCo's velocities of the mechanism, without those of generators."""
        own = np.ones(self.model.nv, bool)
        own[[self.model.joint(generator.name).dofadr[0] for generator in self.motors.generators]] = False
        return own

    def run(self, t_end: float, steps: int, samples: int) -> Motion:
        """Integrate ``steps`` equal steps to t_end, of which every (steps / samples)-th is kept, and the start.

        ValueError if ``samples`` does not divide ``steps``, t_end is not after the start, or a Table ends before.
        EngineFailed if MuJoCo warns of numbers that are not finite or too large.
        """
        check_run(self.engine, self.made.system, self.state.t, t_end, steps, samples)
        m, d = self.model, self.data
        m.opt.timestep = (t_end - self.state.t) / steps
        m.eq_solref[:] = self.softness * m.opt.timestep, self.dampratio
        self.begin()
        qpos, qvel, t = np.zeros((samples + 1, m.nq)), np.zeros((samples + 1, m.nv)), np.zeros(samples + 1)
        qpos[0], qvel[0], t[0] = d.qpos, d.qvel, d.time
        with self.driven(), quiet(self.made.mujoco):
            began = perf_counter()
            for k in range(1, samples + 1):
                self.advance(steps // samples)
                qpos[k], qvel[k], t[k] = d.qpos, d.qvel, d.time
            seconds = perf_counter() - began
            return self.motion(t, qpos, qvel, seconds)

    def advance(self, steps: int) -> None:
        """Integrate many steps; stop where MuJoCo warns."""
        mujoco, m, d = self.made.mujoco, self.model, self.data
        while steps > 0:
            mujoco.mj_step(m, d, min(steps, CHUNK_STEPS))
            steps -= CHUNK_STEPS
            for warning in WARNINGS:
                kind = getattr(mujoco.mjtWarning, f"mjWARN_{warning}")
                found = d.warning[kind]
                if found.number:
                    said = mujoco.mju_warningText(int(kind), found.lastinfo)
                    raise EngineFailed(f"MuJoCo stopped at t = {d.time:.6g} s: {said}")

    def rods(self) -> list[tuple[str, Piece]]:
        """Return names of the Distance joints and the pieces attached to them."""
        pieces = self.made.layout.pieces
        return [(self.made.system.name(p.joint), p) for p in pieces if isinstance(p.joint, Distance)]

    def motion(self, t: np.ndarray, qpos: np.ndarray, qvel: np.ndarray, seconds: float) -> Motion:
        """Evaluate each sample once more: poses, velocities, reactions."""
        mujoco, m, d, n = self.made.mujoco, self.model, self.data, self.ids.size
        check_rods(m, self.rods(), t, qpos)
        shape = (t.size, n)
        r, e, r_dot, omega = (np.zeros((*shape, k)) for k in (3, 4, 3, 3))
        loads: dict[str, list] = {}
        roots = m.body_rootid[self.ids]
        for k in range(t.size):
            d.qpos[:], d.qvel[:], d.time = qpos[k], qvel[k], t[k]
            mujoco.mj_forward(m, d)
            r[k], e[k], omega[k] = d.xpos[self.ids], d.xquat[self.ids], d.cvel[self.ids, :3]
            r_dot[k] = d.cvel[self.ids, 3:] + np.cross(omega[k], r[k] - d.subtree_com[roots])
            for name, wrench in self.reactions.all(d).items():
                loads.setdefault(name, []).append(wrench)
        found = {name: Load(*(np.array(x) for x in zip(*wrenches, strict=True))) for name, wrenches in loads.items()}
        return finite(Motion(t, r, e, r_dot, omega, found, seconds), self.engine)
