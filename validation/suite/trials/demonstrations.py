"""The demos as cases: their rows of computed and theory, and their mechanisms in other engines."""

from collections.abc import Iterable
from functools import cache, partial
from typing import Any

from mbsd3d.extend import Demo, discover
from validation.suite.findings import THEORY, Finding, judged
from validation.suite.trials.trial import STANDS, Run, Trial

WHOLE = {
    "cardan": ("cardan", "cardan_double"),
    "door": ("door", "door_cured"),
    "dzhanibekov": ("dzhanibekov", "dzhanibekov_least", "dzhanibekov_greatest"),
    "heavy_top": ("heavy_top", "heavy_top_slow", "heavy_top_fast"),
}
"""Demo -> its runs with all terms; of other demos the first run is one."""
LONG = {"crank": "engine_I4", "wall": "demo_heavy_top"}
"""Demo -> the case that stands for its mechanism in other engines when the run must be short."""


SHORT = "in a short run a demo of the gallery is compared with its theory only"


def trials(quick: bool) -> list[Trial]:
    """One per mechanism of a demo; the theory stands with the first one. Demos with parameters are the gallery."""
    found = []
    for demo in discover().values():
        if isinstance(demo, Demo):
            make, why = partial(shown, demo, demo.name), SHORT if quick else demo.alone
            found.append(Trial(f"gallery_{demo.name}", "gallery", demo.title, make, {THEORY: rows}, alone=why))
            continue
        names = WHOLE.get(demo.name, (demo.name,))
        for name in names[:1] if quick else names:
            judges = {THEORY: rows} if name == names[0] else {}
            title = demo.title if name == names[0] else f"{demo.title} ({name.removeprefix(demo.name + '_')})"
            alone = STANDS.format(LONG[name]) if quick and name in LONG else ""
            found.append(Trial(f"demo_{name}", "demos", title, partial(shown, demo, name), judges, alone=alone))
    return found


@cache
def outcome(demo: Any) -> Any:
    """Of a demo, run once."""
    return demo.run()


def shown(demo: Any, name: str) -> Run:
    """A run of a demo by its name, or its first one."""
    done = outcome(demo)
    solution = done.solutions.get(name) or next(iter(done.solutions.values()))
    return Run(solution.system, float(solution.t[-1]), solution, solution.state(0), done)


def rows(made: Run) -> Iterable[Finding]:
    """The table of the demo, in the units of its rows."""
    for row in made.source.rows:
        yield judged(THEORY, row.quantity, row.error, row.tolerance, f"absolute, [{row.unit or '-'}]")
