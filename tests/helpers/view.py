"""What a page solves, beside what Python computes for it."""

from dataclasses import replace

import numpy as np

from mbsd3d.extend import compile_system, load_state, loads
from mbsd3d.view.explore.exploration import exploration_data
from mbsd3d.view.explore.lowered import lowered
from mbsd3d.view.explore.sliders import built as built
from mbsd3d.view.scene.frames import frames_of
from mbsd3d.view.scene.overlays import arrows_of, curves_of, traces_of

T = 0.37  # [s] no special time
curves_over = curves_of


def terms_of_kernels(system, state, **terms):
    """Rows and loads of the kernels at a state; the tables of the page and the state as it takes them."""
    model = lowered(system, system.state())
    compiled, n = compile_system(system), len(system.bodies)
    own = np.random.default_rng(8).normal(scale=0.05, size=compiled.model.z_work)  # deflections of force elements
    state = replace(state, z=own, coordinates=np.array([x["start"] for x in model["coordinate"]]))
    data = compiled.data()
    y = load_state(compiled, data, state)
    loads(compiled.model, data, state.t)
    row, body, force = data.row, data.body[:n], data.force
    found = {
        "c": row["c"], "J": row["J"].ravel(), "b": row["b"], "gamma": row["gamma"], "Q": body["Q"].ravel(),
        "h": body["h"].ravel(), "stored": force["potential"].sum(), "work": force["power"].sum(),
        "ownRate": data.state_rate[: own.size].copy(),
    }  # fmt: skip
    return {"model": {**model, "terms": terms}, "y": [*y[: 13 * n], 0.0, *own], "t": T}, found


def explored(run, given, frames, options):
    """What the script of a page reads of its exploration, and (what is drawn, what was asked for)."""
    drawn = arrows_of(run, frames), traces_of(run, frames, options.get("traces"))
    wanted = options.get("curves"), options.get("traces")
    return exploration_data(given, run, np.zeros(3), wanted, drawn), (drawn, wanted)


def frames_shown(run, options):
    """The frames of a page."""
    return frames_of(run, options.get("frames"))
