"""What a package built on mbsd3d may use besides the public names: parts of a command line, of pages and of checks.

``from mbsd3d.extend import number, write_atomically``. These names keep their meaning within a minor version; all other
modules below ``mbsd3d`` are internal and may move. Each is imported on first use.
"""

from importlib import import_module
from typing import Any

NAMES = {
    # checks of what a user gave; errors name the part, the value and the remedy
    "base.checks": ("number", "solvable", "vector"),
    "base.errors": ("Explained", "MbsError", "explaining", "similar"),
    "base.version": ("loading",),
    "base.mass_properties": ("check_inertia",),
    "equations.at_state": ("check_quaternions", "driven_coordinates", "load_state", "pack", "unmet", "worst_joint"),
    "run.simulation": ("check_signals", "check_state", "check_system"),
    "run.rates": ("Rates",),
    # rotations and directions
    "base.directions": ("cross", "matched_perpendiculars", "perpendiculars"),
    "base.quaternions": ("H", "conjugate", "exponential", "logarithm", "multiply", "skew"),
    "base.rotations": ("as_quaternion", "matrix", "quaternion_from_matrix"),
    # files, progress, small dense algebra on one thread
    "base.paths": ("as_path", "package_version", "read_text", "with_suffix", "write_atomically"),
    "base.progress": ("Progress",),
    "base.concurrency": ("on_one_thread", "one_thread"),
    "sweeps.executors": ("closing", "outcomes"),
    "sweeps.ledger": ("Store",),
    # figures and pages in the house style
    "base.style": ("DARK", "LIGHT", "LINE", "THIN", "Theme", "dress", "house", "theme"),
    "base.templates": ("HtmlPage", "page_template"),
    "report.exhibits": ("inline_svg",),
    "report.wording": ("RAISED", "digits"),
    "view.scene.camera": ("VIEW",),
    # commands of the command line, and demos
    "cli": ("main",),
    "cli.play": ("port_option",),
    "cli.support": ("INTERRUPTED", "Failure", "can_view", "keep", "load_system", "ready_folder", "watch"),
    "demos.discovery": ("discover",),
    "demos.form": ("Ablation", "Against", "Curve", "Demo", "Measured", "Quantity", "require"),
    # the mechanism as data: what joints lower to, what forces and signals are made of
    "mechanism.couplings": ("Coupling",),
    "mechanism.force_element": ("ForceElement", "hinge_coordinate"),
    "mechanism.measures": ("Measure",),
    "mechanism.primitives": ("Coordinate", "Primitive"),
    "mechanism.signals": ("as_signal",),
    # a model that is played: `play_model` takes a `Playable`
    "api.playing": ("play_model",),
    "run.playable": ("Built", "Control", "Panel", "Playable", "Seen"),
    "view.play.play": ("Play",),
    "mechanism.signals.terms": ("POLYNOMIAL", "SINE", "evaluate"),
    # the equations at one state, plain and dense, and their derivatives
    "equations.compiled": ("compile_system", "new_data"),
    "equations.dense_solvers": ("DenseEquations", "equations", "mass_matrix", "saddle_matrix"),
    "equations.tables": ("key_of",),
    "equations.elimination": ("eliminate",),
    "linear.variations": ("STEP", "Field", "directions"),
    "compiler.disk": ("CACHE", "compiled_sources"),
}
MODULES = {"joints": "mechanism.joints", "kinds": "kernels.kinds"}
WHERE = {name: module for module, names in NAMES.items() for name in names}

__all__ = [*WHERE, *MODULES]


def __getattr__(name: str) -> Any:
    """The object of a name, from the module where it lives."""
    if name in MODULES:
        value = import_module(f".{MODULES[name]}", __package__)
    elif name in WHERE:
        value = getattr(import_module(f".{WHERE[name]}", __package__), name)
    else:
        raise AttributeError(
            f"module 'mbsd3d.extend' has no attribute {name!r}; there are {', '.join(sorted(__all__))}"
        )
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Public names alone."""
    return sorted(__all__)
