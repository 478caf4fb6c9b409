"""Random mechanisms written as MJCF, URDF and SDF and read back: 50 of a fixed sample, 1000 in `make calibrate`."""

import os

import numpy as np
import pytest
from helpers.exports import (
    PLAIN_JOINTS,
    TREE_JOINTS,
    body,
    carried,
    difference,
    direction,
    joint,
    random_tree,
    read_back,
)
from helpers.mujoco_states import TOLERANCE

from mbsd3d import GROUND, Revolute, State, System, read_mjcf, read_sdf, read_urdf

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:.*(inactive|is fixed):UserWarning")]

MODELS = int(os.environ.get("MBSD3D_TEST_EXPORTED_MODELS", "50"))
SDF_JOINTS = tuple(kind for kind in TREE_JOINTS if kind not in ("Cylindrical", "Planar"))
LOOP_TOLERANCE = 1e-9  # [1] relative: loops near a dead point multiply rounding by some 1e4


def random_loop(seed):
    """Bodies in a row from the ground to the ground, with seven or eight coordinates and six rows that close them."""
    rng = np.random.default_rng(seed)
    bodies, before, joints = [body(rng, f"b{i}") for i in range(3)], GROUND, []
    for kind, one in zip(rng.permutation(["Spherical", "Universal", "Revolute"]), bodies, strict=True):
        joints.append(joint(rng, kind, before, one, f"j{len(joints)}"))
        before = one
    ends = [GROUND, before][:: rng.choice([1, -1])]
    joints.append(Revolute(*ends, at=0.5 * rng.normal(size=3), axis=direction(rng), name="last"))
    return System(bodies, joints)


@pytest.mark.parametrize("seed", range(100, 100 + MODELS))
def test_trees_and_loops_are_read_back(tmp_path, seed):
    count = 2 + seed % 7
    for kinds, suffix, read in (
        (TREE_JOINTS, "xml", read_mjcf), (SDF_JOINTS, "sdf", read_sdf), (PLAIN_JOINTS, "urdf", read_urdf),
    ):  # fmt: skip
        system = random_tree(seed, kinds, count, springs=suffix != "urdf")
        floats = {"floating": True} if suffix == "urdf" and seed % 2 else {}
        write = {"xml": system.to_mjcf, "sdf": system.to_sdf, "urdf": system.to_urdf}[suffix]
        made = write(tmp_path / f"tree.{suffix}")
        assert read_back(system, made, read(made.path, **floats).system, count=3) < TOLERANCE, suffix
    system = random_loop(seed)
    moving = system.assemble(near=State(0.0, system.state().q, np.random.default_rng(seed).normal(size=18)))
    for write, suffix, read in ((system.to_mjcf, "xml", read_mjcf), (system.to_sdf, "sdf", read_sdf)):
        made = write(tmp_path / f"loop.{suffix}")
        found = read(made.path).system
        there = carried(system, moving, found, made.frames)
        assert difference(system, moving, found, there, made.frames) < LOOP_TOLERANCE, suffix
