"""What the sentences of the demos say, as conditions on the run at their moments: `r` the run, `i` the sample there.

None: the sentence says nothing that one run could deny.
"""

import numpy as np


def momentum(r, body, i):
    """Angular momentum of a body about its centre of mass, for bodies whose axes are principal [N m s]."""
    body = r.system.part(body)
    return r.rotation(body)[i] @ (body.inertia @ r.omega_body(body)[i])


def turned(r, body, i):
    """Angle from the pose at the start [deg]."""
    e = np.asarray(r.orientation(body))
    return np.degrees(2 * np.arccos(min(1.0, abs(e[0] @ e[i]))))


def between(r, one, other, i):
    """Angle between the poses of two bodies [deg]."""
    R = r.rotation(one)[i].T @ r.rotation(other)[i]
    return np.degrees(np.arccos((np.trace(R) - 1) / 2))


def slant(r, body, i, axis=(0.0, 0.0, 1.0)):
    """Angle of an axis of the body from the vertical [deg]."""
    return np.degrees(np.arccos(np.clip((r.rotation(body)[i] @ axis)[2], -1, 1)))


def heading(r, body, i):
    """Angle by which the horizontal velocity has turned [deg]."""
    v = r.velocity(body)
    way = np.unwrap(np.arctan2(v[:, 1], v[:, 0]))
    return abs(np.degrees(way[i] - way[0]))


CONDITIONS = {
    "tricycle": (
        lambda r, i: abs(r.velocity("frame")[i, 0] - 6.4) < 0.01,
        lambda r, i: abs(r.angle("head")[i]) < 1e-6 < r.angle("head")[i + 10],
        lambda r, i: r.force("left tyre").normal[i] < 1.0 < r.force("right tyre").normal[i],
        lambda r, i: r.com("left")[i, 2] > r.com("right")[i, 2] + 0.1,
        lambda r, i: slant(r, "frame", i) > 50.0,
    ),
    "control_moment_gyro": (
        lambda r, i: momentum(r, "upper wheel", i)[0] > 0 > momentum(r, "lower wheel", i)[0],
        lambda r, i: momentum(r, "upper wheel", i)[2] > 0 and r.omega("satellite")[i, 2] < 0,
        lambda r, i: (
            np.abs(sum(momentum(r, b.name, i) for b in r.system.bodies)).max() < 1e-6 * momentum(r, "upper wheel", 0)[0]
        ),
    ),
    "gimbal_walk": (
        lambda r, i: r.rate("inner")[i] > 0,
        lambda r, i: r.angle("outer")[i] < -0.01,
        lambda r, i: abs(np.degrees(r.angle("outer")[i]) + 6.27) < 0.3,
    ),
    "gyrocompass": (
        None,
        lambda r, i: abs(np.degrees(r.angle("vertical")[i]) + 60) < 1,
        lambda r, i: abs(r.rate("vertical")[i]) < 0.05 * np.abs(r.rate("vertical")).max(),
        lambda r, i: abs(np.degrees(r.angle("vertical")[i]) + 60) < 1,
    ),
    "helicopter_90": (
        lambda r, i: abs(r.angle("flap")[i]) < 0.02 * np.abs(r.angle("flap")).max(),
        lambda r, i: r.com("blade")[i, 2] > 0.99 * r.com("blade")[:, 2].max(),
        lambda r, i: abs(r.angle("flap")[i]) < 0.02 * np.abs(r.angle("flap")).max(),
        lambda r, i: r.com("blade")[i, 2] < 0.99 * r.com("blade")[:, 2].min(),
    ),
    "jet_pitch_yaw": (
        lambda r, i: abs(r.body_axis("aircraft", (1, 0, 0))[i, 1]) < 1e-9,
        lambda r, i: r.body_axis("aircraft", (1, 0, 0))[i, 2] > 0.2,
        lambda r, i: abs(r.body_axis("aircraft", (1, 0, 0))[i, 1]) > 0.02,
    ),
    "propeller_shake": (
        lambda r, i: np.linalg.norm(r.reaction("hub").moment[i]) < 1,
        lambda r, i: abs(np.linalg.norm(r.reaction("hub").moment[i]) - 400) < 4,
        lambda r, i: np.linalg.norm(r.reaction("hub").moment[i]) < 4,
    ),
    "wheel_on_a_string": (
        None,
        lambda r, i: abs(r.com("wheel")[i, 2] - r.com("wheel")[0, 2]) < 1e-3,
        lambda r, i: np.abs(r.com("wheel")[i] - r.com("wheel")[0]).max() < 1e-3,
    ),
    "dual_spin": (
        lambda r, i: sorted(range(3), key=lambda k: r.system.part("satellite").inertia[k, k])[1] == 2,
        lambda r, i: abs(r.omega_body("wheel")[i, 2]) > 50,
        lambda r, i: r.body_axis("satellite", (0, 0, 1))[i, 2] > 0.999,
    ),
    "dzhanibekov": (
        lambda r, i: all(abs(np.linalg.norm(r.omega(b)[i]) - 5) < 0.01 for b in r.system.bodies),
        lambda r, i: (
            r.omega_body("middle moment")[i, 1] < 0
            and all(abs(momentum(r, "middle moment", i) - momentum(r, "middle moment", 0)) < 1e-4)
        ),
        lambda r, i: r.omega_body("middle moment")[i, 1] < -4.98,
        lambda r, i: r.omega_body("least moment")[i, 0] > 4.99 and r.omega_body("greatest moment")[i, 2] > 4.99,
    ),
    "explorer_flat_spin": (
        lambda r, i: abs(r.omega_body("satellite")[i, 0]) > 4.9,
        lambda r, i: r.energy().total[i] < 0.8 * r.energy().total[0],
        lambda r, i: abs(r.omega_body("satellite")[i, 0]) < 0.1 and np.linalg.norm(r.omega("satellite")[i]) > 0.8,
    ),
    "falling_cat": (
        lambda r, i: r.body_axis("fore", (0, 0, 1))[i, 2] > 0.99,
        lambda r, i: np.dot(r.body_axis("fore", (1, 0, 0))[i], r.body_axis("hind", (1, 0, 0))[i]) < 0.9,
        lambda r, i: r.body_axis("fore", (0, 0, 1))[i, 2] < -0.99,
    ),
    "gravity_gradient": (
        None,
        lambda r, i: abs(np.degrees(r.angle("pitch")[i]) + 40) < 1,
        lambda r, i: abs(r.rate("pitch")[i]) < 0.1 * np.abs(r.rate("pitch")).max(),
        lambda r, i: np.ptp(np.degrees(r.angle("pitch"))) < 81,
    ),
    "poinsot": (
        None,
        None,
        lambda r, i: (
            np.abs(r.omega_body("body")[i] - r.omega_body("body")[0]).max() < 1e-2
            and abs(turned(r, "body", i) - 38.557) < 0.5
        ),
    ),
    "satellite_nutation": (
        None,
        lambda r, i: np.dot(r.body_axis("body", (0, 0, 1))[i], r.body_axis("body", (0, 0, 1))[0]) > 0.9999,
        lambda r, i: abs(1.257 * r.omega_body("body")[i, 2] - 2 * np.pi) < 0.01,
    ),
    "ball_holonomy": (
        lambda r, i: abs(r.omega("ball")[:, 2]).max() < 1e-6,
        lambda r, i: r.com("ball")[i, 0] < -0.24,
        lambda r, i: np.abs(r.com("ball")[i] - r.com("ball")[0]).max() < 1e-3 and abs(turned(r, "ball", i) - 111) < 1,
    ),
    "ball_on_turntable": (
        None,
        lambda r, i: abs(heading(r, "ball", i) - 360 * 2 / 7) < 1,
        lambda r, i: abs(heading(r, "ball", i) - 360 * 4 / 7) < 1,
    ),
    "coin_on_springs": (
        None,
        lambda r, i: abs(heading(r, "coin", i) - 180) < 2,
    ),
    "euler_disc": (
        None,
        lambda r, i: abs(turned(r, "disc", i) - 5.5) < 0.1,
        lambda r, i: abs(turned(r, "disc", i) - 11) < 0.2,
    ),
    "euler_disc_end": (
        lambda r, i: abs(slant(r, "disc", i) - 10) < 0.1,
        lambda r, i: slant(r, "disc", i) < 6.5,
        lambda r, i: abs(slant(r, "disc", i) - 1.53) < 0.05,
    ),
    "heavy_top": (
        lambda r, i: r.acceleration("top")[i, 2] < 0,
        lambda r, i: abs(r.velocity("top")[i, 2]) < 0.05,
        lambda r, i: abs(r.com("top")[i, 2] - r.com("top")[0, 2]) < 1e-3 and r.com("top")[i, 0] < -0.1,
        lambda r, i: (
            abs(r.com("top")[i, 2] - r.com("top")[0, 2]) < 1e-3
            and np.linalg.norm(r.com("top")[i] - r.com("top")[0]) < 0.2
        ),
    ),
    "rattleback": (
        lambda r, i: r.omega("stone")[i, 2] > 4.9,
        lambda r, i: np.hypot(*r.omega("stone")[i, :2]) > 1,
        lambda r, i: r.omega("stone")[i, 2] < 0,
    ),
    "rolling_coin": (
        lambda r, i: abs(r.velocity("coin")[i, 0] - 0.15) < 1e-3,
        lambda r, i: slant(r, "coin", i, (0, 1, 0)) < slant(r, "coin", i // 2, (0, 1, 0)),
    ),
    "skate_on_slope": (
        None,
        lambda r, i: abs(r.com("skate")[i, 2] - r.com("skate")[:, 2].min()) < 1e-4,
        lambda r, i: abs(r.com("skate")[i, 2]) < 1e-4 and abs(r.com("skate")[i, 1]) > 0.3,
        lambda r, i: abs(r.com("skate")[i, 1]) > 2,
    ),
    "sleeping_top": (
        lambda r, i: abs(np.linalg.norm(r.omega("top")[i]) - 60) < 0.1,
        lambda r, i: slant(r, "top", i) > slant(r, "top", i // 2),
    ),
    "slide_to_roll": (
        lambda r, i: abs(r.omega("ball")[i, 1]) < 1e-6,
        lambda r, i: abs(r.velocity("ball")[i, 0] - 25 / 7) < 1e-2,
        lambda r, i: abs(r.velocity("ball")[i, 0] - 25 / 7) < 1e-3,
    ),
    "spinning_egg": (
        lambda r, i: r.com("egg")[i, 2] < 0.0225,
        None,
        lambda r, i: slant(r, "egg", i) < 15 or slant(r, "egg", i) > 165,
    ),
    "tippe_top": (
        None,
        None,
        lambda r, i: r.com("top")[i, 2] > r.com("top")[0, 2] + 0.004,
    ),
    "two_circle_roller": (
        None,
        lambda r, i: np.ptp(r.com("roller")[:, 0]) > 0.1,
        lambda r, i: np.ptp(r.com("roller")[:, 2]) < 1e-9,
    ),
    "foucault": (
        None,
        lambda r, i: abs(0.03 * np.sin(np.radians(48.85)) * 22 - np.radians(28.5)) < 0.01,
        lambda r, i: abs(turned(r, "laboratory", i) - 75.6) < 1,
    ),
    "gimbal_lock": (
        None,
        None,
        lambda r, i: abs(r.rate("azimuth")[i]) > 0.99 * np.abs(r.rate("azimuth")).max(),
    ),
    "non_commuting": (
        None,
        lambda r, i: turned(r, "x then y", i) > 89 and turned(r, "y then x", i) > 89,
        lambda r, i: abs(between(r, "x then y", "y then x", i) - 120) < 0.1,
    ),
    "spherical_pendulum": (
        None,
        lambda r, i: abs(np.degrees(np.arctan2(*r.com("bob")[i, 1::-1])) - 104.71) < 0.7,
        lambda r, i: abs(180 - abs(np.degrees(np.arctan2(*r.com("bob")[i, 1::-1]))) - 29.4) < 0.7,
    ),
    "wrist_singularity": (
        lambda r, i: abs(np.linalg.norm(r.omega("hand")[i]) - 1) < 0.01,
        None,
        lambda r, i: abs(abs(r.rate("axis 4")[i]) - 19.1) < 0.2,
    ),
    "bennett": (
        None,
        lambda r, i: abs(np.degrees(r.angle("hinge 1")[i]) - 50) < 1,
        lambda r, i: abs(np.degrees(r.angle("hinge 2")[i]) + 108) < 0.2,
    ),
    "door": (
        None,
        lambda r, i: abs(np.degrees(r.angle("top")[i]) + 60) < 3,
        None,
    ),
    "kaleidocycle": (
        None,
        lambda r, i: abs(np.degrees(r.angle("hinge 1")[i]) - 107.5) < 2,
        lambda r, i: abs(np.degrees(r.angle("hinge 1")[i]) - 215) < 1,
    ),
    "robot_arm": (
        lambda r, i: abs(r.effort("motor 2")[i] - 63.4) < 0.1,
        lambda r, i: r.effort("motor 3")[i] < 0.5 * r.effort("motor 3")[0],
    ),
    "rssr": (
        None,
        lambda r, i: abs(r.rate("rocker shaft")[i]) < 0.1,
        lambda r, i: (
            abs(np.degrees(np.ptp(r.angle("rocker shaft"))) - 72.4) < 0.1 and abs(r.rate("rocker shaft")[i]) < 0.1
        ),
    ),
    "sarrus": (
        None,
        lambda r, i: turned(r, "platform", i) < 1e-3 and np.hypot(*r.position("platform")[i, :2]) < 1e-6,
        lambda r, i: (
            abs(r.position("platform")[i, 2] - 0.766) < 0.002 and np.hypot(*r.position("platform")[i, :2]) < 1e-6
        ),
    ),
    "schatz": (
        None,
        lambda r, i: turned(r, "link 3", i) > 60,
        lambda r, i: abs(np.degrees(r.angle("hinge 6")[i]) - 360) < 1,
    ),
    "stewart": (
        None,
        None,
        lambda r, i: abs(np.linalg.norm(r.reaction("leg 1").force[i]) - 2338) < 5,
    ),
    "cardan": (
        lambda r, i: abs(r.omega_body("driven")[i, 0] - 11.55) < 0.02,
        lambda r, i: abs(r.omega_body("driven")[i, 0] - 8.66) < 0.02,
        lambda r, i: abs(r.omega_body("driven")[i, 0] - 11.55) < 0.02,
    ),
    "cardan_couple": (
        lambda r, i: abs(r.reaction("bearing").moment[i, 1]) < 1,
        lambda r, i: abs(r.reaction("bearing").moment[i, 1] - 171) < 1,
        lambda r, i: abs(r.reaction("bearing").moment[i, 1]) < 1,
    ),
    "cardan_wrong_phase": (
        lambda r, i: abs(r.omega_body("driven")[i, 0] - 13.33) < 0.02,
        lambda r, i: abs(r.omega_body("driven")[i, 0] - 7.5) < 0.02,
        None,
    ),
    "crank": (
        lambda r, i: r.slide("bore")[i] > -1e-6,
        lambda r, i: (
            np.linalg.norm(r.reaction("bearing").force[i]) < 0.5 * np.linalg.norm(r.reaction("bearing").force[0])
        ),
        None,
    ),
    "cv_joint": (
        None,
        lambda r, i: (
            np.ptp(r.reaction("bearing").moment[:, 1]) < 1e-6 and abs(r.reaction("bearing").moment[i, 1] - 88.2) < 0.1
        ),
    ),
    "dynamic_unbalance": (
        lambda r, i: np.linalg.norm(np.cross(momentum(r, r.system.bodies[0].name, i), (0, 0, 1))) > 0.1,
        lambda r, i: abs(np.linalg.norm(r.reaction("upper bearing").force[i]) - 90) < 1,
        lambda r, i: np.dot(r.reaction("upper bearing").force[i], r.reaction("upper bearing").force[0]) < 0,
    ),
    "swash_plate": (
        None,
        lambda r, i: abs(r.slide("bore 1")[i] - 0.0325) < 1e-4,
        lambda r, i: abs(r.slide("bore 1")[i]) < 1e-4,
    ),
    "v8_wobble": (
        lambda r, i: abs(r.reaction("main bearings").moment[i, 1]) > 2500,
        lambda r, i: abs(r.reaction("main bearings").moment[i, 2]) > 2500,
        lambda r, i: np.ptp(np.linalg.norm(r.reaction("main bearings").moment, axis=1)) < 0.15 * 2818,
    ),
    "crossed_gears": (
        None,
        lambda r, i: (
            abs(np.degrees(r.angle("pinion shaft")[i]) - 358) < 3
            and abs(np.degrees(r.angle("wheel shaft")[i]) + 180) < 2
        ),
    ),
    "differential": (
        None,
        lambda r, i: abs(r.rate("left")[i] - 10) < 0.1,
        lambda r, i: abs(r.rate("left")[i] + r.rate("right")[i] - 80) < 1e-6,
    ),
    "helical_thrust": (
        None,
        lambda r, i: abs(r.reaction("mesh").force[i, 2] + 466) < 1,
    ),
    "hypoid": (
        None,
        lambda r, i: abs(np.abs(r.reaction("mesh").force[i]).max() - 3600) < 1,
    ),
    "nutating_gear": (
        None,
        lambda r, i: abs(r.angle("input")[i] - 10 * np.pi) < 0.1,
        lambda r, i: abs(turned(r, "output", i) - 32.9) < 0.3,
    ),
    "barrel_cam": (
        None,
        lambda r, i: abs(r.rate("rail")[i]) > 0.99 * np.abs(r.rate("rail")).max(),
        lambda r, i: abs(r.slide("rail")[i] - 0.08) < 1e-4,
    ),
    "roller_cam": (
        lambda r, i: r.com("valve")[i, 2] > r.com("valve")[:, 2].max() - 1e-6,
        None,
        lambda r, i: r.com("valve")[i, 2] < r.com("valve")[:, 2].min() + 1e-6,
    ),
    "block_and_tackle": (
        None,
        lambda r, i: abs(np.max(r.force("rope").tension[i]) - 346) < 4,
        lambda r, i: np.abs(r.force("rope").tension[i] - (77, 112, 163, 237, 346)).max() < 1,
    ),
    "clutch_start": (
        lambda r, i: abs(np.linalg.norm(r.omega("engine")[i]) - 9) < 0.01,
        lambda r, i: np.linalg.norm(r.omega("engine")[i]) > np.linalg.norm(r.omega("car")[i]) + 0.5,
        lambda r, i: abs(np.linalg.norm(r.omega("engine")[i]) - np.linalg.norm(r.omega("car")[i])) < 0.1,
    ),
    "crank_play": (
        None,
        lambda r, i: min(abs(e.t - r.t[i]) for e in r.events) < 2e-4,
        lambda r, i: min(abs(e.t - r.t[i]) for e in r.events) < 2e-4,
    ),
    "gear_rattle": (
        lambda r, i: abs(r.angle("engine shaft")[i]) < 1e-9 and np.ptp(r.angle("engine shaft")) > 0.1,
        lambda r, i: r.events[0].t == r.t[i] and "upper" in r.events[0].what,
        lambda r, i: r.events[1].t == r.t[i] and "lower" in r.events[1].what,
    ),
    "geneva_drive": (
        lambda r, i: np.ptp(r.angle("wheel shaft")[: i + 200]) < 1e-12,
        lambda r, i: abs(r.angle("wheel shaft")[i]) < 1e-3 and 0.0 < -r.rate("wheel shaft")[i] < 0.1,
        lambda r, i: abs(-r.rate("wheel shaft")[i] / r.rate("driver shaft")[i] - 2.414) < 1e-3,
        lambda r, i: abs(np.degrees(r.angle("wheel shaft")[i]) + 90) < 1e-9 and abs(r.rate("wheel shaft")[i]) < 1e-9,
    ),
    "latched_door": (
        lambda r, i: r.rate("hinge")[i] > 3.0,
        lambda r, i: r.events[0].t == r.t[i] and r.events[0].lost > 0.5 * r.energy().kinetic[0],
        lambda r, i: r.events[1].t == r.t[i] and abs(r.angle("hinge")[i]) < 1e-9,
    ),
    "ratchet_hoist": (
        lambda r, i: r.rate("axle")[i + 5] > 0.1 and abs(r.rate("axle")[i + 5] - r.rate("pivot")[i + 5]) < 1e-9,
        lambda r, i: abs(r.angle("axle")[i] * 16 / (2 * np.pi) - 2.546) < 0.001 and abs(r.rate("pivot")[i]) < 1e-9,
        lambda r, i: abs(r.angle("axle")[i] * 16 / (2 * np.pi) - 2) < 1e-9 and any(e.t == r.t[i] for e in r.events),
        lambda r, i: abs(r.angle("axle")[i] * 16 / (2 * np.pi) - 6) < 1e-9,
    ),
    "screw_jack": (
        None,
        lambda r, i: abs(r.position("load")[-1, 2] - r.position("load")[i, 2]) < 1e-4,
    ),
    "double_wishbone": (
        None,
        lambda r, i: turned(r, "wheel", i) > 1,
    ),
    "motorcycle_crank_lean": (
        None,
        None,
    ),
    "parking": (
        None,
        None,
        lambda r, i: abs(abs(r.position("car")[i, 1]) - 0.75) < 0.005 and abs(r.position("car")[i, 0]) < 1e-3,
    ),
    "steering_linkage": (
        None,
        lambda r, i: (
            abs(abs(np.degrees(r.angle("left kingpin")[i])) - 25) < 0.2
            and abs(abs(np.degrees(r.angle("right kingpin")[i])) - 22.2) < 0.2
        ),
    ),
    "transverse_engine_cornering": (
        None,
        None,
    ),
    "tyre_slip": (
        None,
        lambda r, i: abs(r.force("tyre 0").lateral[i] - 484) < 1 and abs(r.force("tyre 3").lateral[i] - 59) < 1,
    ),
    "wheel_drop": (
        None,
        lambda r, i: r.velocity("wheel")[i, 2] < -1,
        lambda r, i: abs(r.velocity("wheel")[i, 2]) < 0.3,
        lambda r, i: r.velocity("wheel")[i, 2] > 0,
    ),
    "car_limit": (
        lambda r, i: abs(np.linalg.norm(r.velocity("chassis")[i]) - 20) < 0.01,
        lambda r, i: r.body_axis("chassis", (0, 1, 0))[i, 2] * r.velocity("chassis")[-1, 1] > 0,
        None,
    ),
    "double_lane_change": (
        None,
        None,
        lambda r, i: r.com("chassis")[i, 1] > 3.5,
        lambda r, i: r.com("chassis")[i, 1] < -0.5,
    ),
    "engine_in_the_car": (
        lambda r, i: abs(np.linalg.norm(r.velocity("chassis")[i]) - 26) < 0.01,
        None,
    ),
    "fishhook": (
        lambda r, i: abs(np.linalg.norm(r.velocity("chassis")[i]) - 22) < 0.01,
        lambda r, i: slant(r, "chassis", i) < 12,
        lambda r, i: r.com("front right wheel")[i, 2] > 0.4 and r.com("rear right wheel")[i, 2] > 0.4,
        lambda r, i: slant(r, "chassis", i) > 45,
    ),
    "roll_bars": (
        None,
        lambda r, i: (
            np.linalg.norm(r.force("front right tyre").normal[i]) > np.linalg.norm(r.force("rear right tyre").normal[i])
        ),
        None,
    ),
    "single_track": (
        None,
        lambda r, i: abs(np.linalg.norm(r.omega("car")[i]) / 0.01 - 5.39) < 0.02,
    ),
    "step_steer": (
        None,
        None,
        None,
        None,
    ),
    "wall": (
        None,
        lambda r, i: r.com("wheel")[i, 1] > 1,
        lambda r, i: abs(r.com("wheel")[i, 1] - 3.14) < 0.02,
    ),
    "countersteer": (
        None,
        lambda r, i: r.angle("steer")[i] > 0.02,
        lambda r, i: r.body_axis("frame", (0, 1, 0))[i, 2] < 0,
        lambda r, i: r.com("frame")[i, 1] < -0.5 or r.com("frame")[i, 1] > 0.5,
    ),
    "no_hands": (
        None,
        lambda r, i: r.angle("steer")[i] * r.body_axis("frame", (0, 1, 0))[i, 2] > 1e-3,
        lambda r, i: abs(np.degrees(np.arcsin(r.body_axis("frame", (0, 1, 0))[i, 2]))) < 2,
    ),
}
