"""Continuation to a pose: asked-for values and drivers change along the motion, so that every hinge counts its turns.

F(q) = (1 - s) F(q_0) for s from 0 to 1. A step goes along the motion that the rows allow, every body on a screw that
rests in the body that carries it, and Newton's method corrects it. Where joints turn evenly, as in gears, steps grow.
"""

from dataclasses import dataclass

import numpy as np

from ...equations.jacobian import displacement_units
from ...kernels.kinds import ANGLE, BEARING, SLIDE
from .joint_motion import JointGraph
from .pose_equations import PoseEquations

FIRST_TURN_MAX = 1.0  # [rad] of a joint in the first step, or lengths of a slide; half a turn would be ambiguous
MISS_MAX = 0.3  # [rad] between the pose that a step expects and the one it finds, a twentieth of a turn
POSE_MISS_TARGET = 0.15  # [rad] between expected and found pose, for which steps are chosen; half of what is allowed

GROWTH_MAX = 8.0  # [1] of a step over the last one, where joints turn evenly to rounding
STEP_MIN = 1e-6  # [1] of the way; shorter ones end in a singular pose, or where what is asked for is out of reach
CORRECTIONS_MAX = 12  # of a step on the way; one that takes more was too long
STEP_GAP_MAX = 1e-10  # [1] residual on the way, a tenth of what counts as closed


@dataclass(frozen=True)
class Heading:
    """Motion that the rows allow at a pose, over the whole way."""

    motion: np.ndarray  # (6 n,) m, rad
    rates: np.ndarray  # what stays even where joints turn evenly: relative motions of bodies, coordinates, joints
    turn: float  # rad, the largest change of a joint; of slides in lengths of the model
    rank: int  # of the rows, 0 = not computed


class Continuation:
    """A pose on its way to F = 0.

    ``gone``: share of the way behind it; ``counted`` hinge coordinates and ``rank`` of the rows, 0 = not computed,
    where it began.
    """

    def __init__(self, equations: PoseEquations, graph: JointGraph, tolerance: float) -> None:
        self.equations, self.graph, self.tolerance, self.rank = equations, graph, tolerance, 0
        self.start, self.counted, self.gone = equations.residual(), equations.counted(), 0.0
        kind, length = equations.model.coordinate["kind"], equations.model.length
        self.units = np.where(np.isin(kind, (ANGLE, BEARING)), 1.0, np.where(kind == SLIDE, length, np.inf))
        self.even = not np.isinf(self.units).any()  # joints along curves may turn evenly for a while, and then not

    def follow(self) -> bool:
        """Follow the way; return False where it does not lead on, with the pose reached.

        Rates are expected to change as they did in the last step.
        """
        equations, heading, bend = self.equations, self.heading(None), 0.0
        self.rank = heading.rank
        step = min(1.0, FIRST_TURN_MAX / max(heading.turn, 1e-300))
        twists = 6 * self.graph.parent.size + self.units.size  # place of the first one in the rates
        while True:
            before = equations.q.copy(), equations.counted()
            miss = self.advance(heading.rates + 0.5 * step * bend, step)
            if miss <= MISS_MAX and self.gone + step >= 1.0:
                self.gone = 1.0
                return True
            if miss <= MISS_MAX:
                ahead = self.heading(heading)
                unexpected = np.abs(ahead.rates - heading.rates - step * bend)[twists:]
                miss = max(miss, 0.5 * step * float(unexpected.max(initial=0.0)))
            if miss <= MISS_MAX:
                self.gone += step
                heading, bend, step = ahead, (ahead.rates - heading.rates) / step, self.next_step(ahead, step, miss)
            else:
                equations.put(*before)
                step *= 0.5
                if step < STEP_MIN:
                    return False

    def next_step(self, heading: Heading, step: float, miss: float) -> float:
        """Return a step that misses by MISS_AIM, at most GROWTH_MAX times the last one; misses grow with its cube."""
        step *= min(GROWTH_MAX, (POSE_MISS_TARGET / max(miss, 1e-300)) ** (1.0 / 3.0))
        return min(step, 1.0 - self.gone, 1.0 if self.even else FIRST_TURN_MAX / max(heading.turn, 1e-300))

    def heading(self, before: Heading | None) -> Heading:
        """Return the motion from here to F = 0, of those that move the joints least.

        In a singular pose, where the rows leave more open than before, it goes on as it came.
        """
        equations, length = self.equations, self.equations.model.length
        wanted = -self.start
        motion, rank, B = equations.joint_motion(wanted, self.graph)
        if before is not None and rank < before.rank:
            more, rank, B = equations.joint_motion(wanted - equations.change(before.motion), self.graph)
            motion = before.motion + more
        rates = equations.rates(motion)
        twists = B.times(motion / displacement_units(length, equations.model.body.size))
        turn = max(float(np.abs(x).max(initial=0.0)) for x in (twists, rates / self.units))
        relative = self.graph.relative(equations.data, motion)
        return Heading(motion, np.concatenate([relative, rates, twists]), turn, rank)

    def advance(self, rates: np.ndarray, step: float) -> float:
        """Take a step; return the largest difference of joints and bodies from what was expected [rad, lengths].

        inf where the rows do not close there.
        """
        equations, length, n = self.equations, self.equations.model.length, 6 * self.graph.parent.size
        expected = self.graph.moved(equations.data, step * rates[:n])
        counted = equations.counted() + step * rates[n : n + self.units.size]
        equations.put(expected, counted)
        left = 1.0 - self.gone - step
        if left > 0.0:
            gap = equations.close(left * self.start, self.graph, enough=STEP_GAP_MAX, most=CORRECTIONS_MAX)
        else:
            gap = equations.close(0.0, self.graph)
        if gap > self.tolerance:
            return np.inf
        found, expected = equations.q.reshape(-1, 7), expected.reshape(-1, 7)
        shift = np.abs(found[:, :3] - expected[:, :3]).max() / length
        turn = 2.0 * np.arccos(np.minimum(np.abs(np.sum(found[:, 3:] * expected[:, 3:], axis=1)), 1.0)).max()
        recounted = np.abs((equations.counted() - counted) / self.units).max(initial=0.0)
        return float(max(shift, turn, recounted))
