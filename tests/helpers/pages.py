"""Pages of one mechanism, open in a browser, and what tests do with them."""

from contextlib import contextmanager

import numpy as np

from helpers.browser import visit

END, COUNT = 0.6, 61  # s, samples: frames at the same times, so that nothing is interpolated
TITLE = "Probe <b>ä</b> & \"q\" </title>"  # fmt: skip
HINGE = "<i>Lager</i> 1/2"
READY = "document.documentElement.dataset.ready === 'yes'"
# Three pictures after the client took its last messages: then what is seen is what was asked for
SETTLED = """async () => {
  const picture = () => new Promise((done) => requestAnimationFrame(done));
  do { await picture(); } while (__viserMutable.messageQueue.length);
  for (let i = 0; i < 3; i++) { __viserMutable.requestRender(); await picture(); }
}"""
# Names of what reaches out of the picture: corners of every body, link and path, by the camera's own projection
OUTSIDE = """() => {
  const {nodeRefFromName, camera} = __viserMutable, outside = [];
  for (const [name, node] of Object.entries(nodeRefFromName)) {
    if (!node || !/^.(bodies|links|traces)/.test(name)) continue;
    node.updateWorldMatrix(true, false);
    node.traverseVisible((part) => {
      const points = part.geometry?.attributes;
      if (!part.visible || !points || part.isInstancedMesh) return;
      const corners = points.instanceStart ? [points.instanceStart, points.instanceEnd] : [points.position];
      const at = new node.position.constructor();
      for (const list of corners) for (let i = 0; i < list.count; i++) {
        at.fromBufferAttribute(list, i).applyMatrix4(part.matrixWorld).project(camera);
        if (Math.max(Math.abs(at.x), Math.abs(at.y)) > 1) return outside.push(name);
      }
    });
  }
  return outside;
}"""
# Smooth edges and shadows that follow are half of what is drawn in software.
PLAIN_EDGES = """{
  const made = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return made.call(this, kind, {...options, antialias: false});
  };
}"""
RESTING_SHADOWS = """() => {
  let top = __viserMutable.nodeRefFromName["/ready"];
  while (top.parent) top = top.parent;
  top.traverse((node) => { if (node.shadow) node.shadow.autoUpdate = false; });
}"""


@contextmanager
def opened(browser, path, **options):
    """A page that is ready; leaving it fails if it complained of anything."""
    with visit(browser, path, query="?fixedDpr=1", **options) as seen:  # else the client draws coarser where it is slow
        seen.wait(READY)
        seen.run(SETTLED)
        yield seen
        assert seen.complaints == []


@contextmanager
def many_pages(browser, blank):
    """A small window for many pages in turn: what is drawn in software takes its time by the pixel."""
    blank.write_text("<!doctype html><link rel=icon href=data:,>")
    with visit(browser, blank, width=480, height=300) as seen:
        seen.page.add_init_script(PLAIN_EDGES)
        yield seen


@contextmanager
def shown(seen, path):
    """Another page in such a window, which saves the start of a browser; as `opened`, but shadows stay."""
    seen.errors.clear(), seen.refused.clear(), seen.failed.clear()
    seen.page.goto(f"{path.resolve().as_uri()}?fixedDpr=1")
    seen.wait(READY)
    seen.run(RESTING_SHADOWS)
    seen.run(SETTLED)
    yield seen
    assert seen.complaints == []


def seek(seen, t):
    """Bring the page to a time, as its slider does, and wait for the picture."""
    seen.run("t => { mbsd3d.play(false); mbsd3d.seek(t); }", t)
    seen.run(SETTLED)


def scene(seen):
    """The picture of the mechanism."""
    return seen.pixels("#scene")


def differing(first, second):
    """Number of pixels that differ by more than the rounding of colours."""
    return int((np.abs(first.astype(int) - second).max(axis=2) > 3).sum())


def covered(picture):
    """Share of the pixels that are not paper, the most frequent colour."""
    colours, counts = np.unique(picture.reshape(-1, 3), axis=0, return_counts=True)
    return 1.0 - counts.max() / counts.sum(), len(colours)


def tick(seen, on, *names):
    """Set switches by clicking them, in the panel opened for it."""
    panel = seen.page.locator("#switches summary")
    panel.click()
    for name in names:
        seen.page.get_by_role("checkbox", name=name, exact=True).set_checked(on)
    panel.click()
    seen.run(SETTLED)
