"""Panel of a live view: play and pause, time, speed, switches and curves, made of viser's widgets."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ...base.style import Theme, theme
from ..scene.frames import Frames
from ..scene.overlays import Arrows, Curve
from .content import Content
from .recorder import printable
from .stage import Stage

if TYPE_CHECKING:
    from viser import GuiApi, GuiCheckboxHandle, GuiEvent, GuiSliderHandle
    from viser.uplot import Series

PLAYBACK_SPEEDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
CURVE_POINTS_MAX = 300  # [points] of a curve; the whole curve is sent again whenever its cursor moves
CURSOR_INTERVAL_FRAMES = 3  # [frames] from one move of the cursors to the next


class Player(Protocol):
    """Settings that the widgets read and write."""

    playing: bool
    speed: float  # seconds of the run per second
    time: float  # [s]

    def refresh(self) -> None:
        """Redraw the scene."""


class Panel:
    """Widgets for a player and the layers of a stage."""

    def __init__(self, gui: "GuiApi", player: Player, stage: Stage, content: Content, dark: bool) -> None:
        frames = content.frames
        self.gui, self.player, self.stage, self.pictures = gui, player, stage, 0
        gui.main_panel.dock_right()
        gui.main_panel.set_width(380)
        self.slider = self.add_player(frames) if frames.t.size > 1 else None
        with gui.add_folder("show and hide", expand_by_default=False):
            self.switches = self.add_switches(content.arrows)
        self.plots = [Plot(gui, frames.t, curve, theme(dark)) for curve in content.curves]

    def add_player(self, frames: Frames) -> "GuiSliderHandle[float]":
        """Add button, slider and speeds; return the slider."""
        from viser import Icon

        player, gui = self.player, self.gui
        button = gui.add_button("Pause", icon=Icon.PLAYER_PAUSE)
        first, last = float(frames.t[0]), float(frames.t[-1])
        slider = gui.add_slider("time [s]", first, last, (last - first) / 1000.0, first)
        speeds = sorted({*PLAYBACK_SPEEDS, player.speed})
        speed = gui.add_dropdown("speed", [f"{x:g}x" for x in speeds], initial_value=f"{player.speed:g}x")

        @button.on_click
        def _(_: object) -> None:
            player.playing = not player.playing
            button.label = "Pause" if player.playing else "Play"
            button.icon = Icon.PLAYER_PAUSE if player.playing else Icon.PLAYER_PLAY

        @slider.on_update
        def _(event: "GuiEvent[GuiSliderHandle[float]]") -> None:
            if event.client_id is not None:  # moved by a reader, not by the player
                player.time = float(slider.value)

        @speed.on_update
        def _(_: object) -> None:
            player.speed = float(speed.value.removesuffix("x"))

        return slider

    def add_switches(self, arrows: Sequence[Arrows]) -> dict[str, "GuiCheckboxHandle"]:
        """Add a check box for every layer that holds something."""
        longest = {x.kind: x.longest for x in arrows}
        unit = {x.kind: x.unit for x in arrows}
        open_share = {x.kind for x in arrows if any(x.uncertain)}
        boxes = {}
        for layer, nodes in self.stage.layers.items():
            if not nodes:
                continue
            hint = f"longest arrow: {longest[layer]:.3g} {unit[layer]}" if layer in longest else None
            hint = f"{hint}; pale: not unique" if layer in open_share else hint
            boxes[layer] = self.add_switch(layer, bool(nodes[0].visible), hint)
        return boxes

    def add_switch(self, layer: str, visible: bool, hint: str | None) -> "GuiCheckboxHandle":
        """Add a check box for a layer."""
        box = self.gui.add_checkbox(layer, visible, hint=hint)

        @box.on_update
        def _(_: object) -> None:
            self.switch(layer, box.value)

        return box

    def switch(self, layer: str, visible: bool) -> None:
        """Show or hide a layer; arrows were not moved while they were hidden."""
        self.player.refresh()
        self.stage.show(layer, visible)

    def shown(self, layer: str) -> bool:
        """Return whether a layer is switched on."""
        return layer in self.switches and self.switches[layer].value

    def show(self, t: float) -> None:
        """Move slider and cursors to a time [s]."""
        if self.slider is not None:
            self.slider.value = t  # type: ignore[misc]  # a property whose setter viser defines apart from it
        if self.pictures % CURSOR_INTERVAL_FRAMES == 0 or not self.player.playing:
            for plot in self.plots:
                plot.move(t)
        self.pictures += 1


class Plot:
    """Curve with a cursor: a line of two points at the time, the last series."""

    def __init__(self, gui: "GuiApi", t: np.ndarray, curve: Curve, look: Theme) -> None:
        self.t = np.linspace(t[0], t[-1], min(CURVE_POINTS_MAX, t.size))
        self.lines = [np.interp(self.t, t, values) for _, values in curve.lines]
        low, high = min(map(np.min, self.lines)), max(map(np.max, self.lines))
        margin = 0.05 * float(high - low) or 0.05 * abs(float(high)) or 1.0
        self.range = (float(low) - margin, float(high) + margin)
        series: list[Series] = [{"label": "time [s]"}]
        series += [
            {"label": printable(name), "stroke": look.colour(i), "width": 2} for i, (name, _) in enumerate(curve.lines)
        ]
        series += [{"label": "now", "stroke": look.muted, "width": 1.5, "points": {"show": False}}]
        self.handle = gui.add_uplot(
            self.data(float(t[0])), tuple(series), title=printable(f"{curve.label} [{curve.unit}]"), height=190,
            legend={"show": len(curve.lines) > 1, "live": False},
            scales={"x": {"time": False, "auto": True}, "y": {"auto": False, "range": self.range}},
        )  # fmt: skip

    def data(self, now: float) -> tuple[np.ndarray, ...]:
        """Return times and lines with the time of the cursor inserted twice, and the cursor from bottom to top."""
        k = int(np.searchsorted(self.t, now))
        t = np.insert(self.t, k, [now, now])
        cursor = np.full(t.size, np.nan)
        cursor[k : k + 2] = self.range
        return (t, *(np.interp(t, self.t, values) for values in self.lines), cursor)

    def move(self, now: float) -> None:
        """Move the cursor to a time [s]."""
        self.handle.data = self.data(now)
