// A player within a page of the gallery. Players side by side keep in step: what the reader tells one of them, the page
// around them tells the others; the one that is first at its end and starts anew takes them with it. The page says when
// it is in view, and where to go; it is told of the moment, and of what the reader points at.
(() => {
  const [scrub, button, speed] = ["scrub", "play", "speed"].map((id) => document.getElementById(id));
  const player = window.mbsd3d;
  if (!scrub || parent === window) return;
  const plays = () => button.getAttribute("aria-label") === "pause", say = (what) => parent.postMessage(what, "*");
  let told = false, time = scrub.valueAsNumber, on = plays(), ready = false, inView = false, own = false, last = "";
  function tell() {
    if (!told) say({time: scrub.valueAsNumber, plays: plays(), speed: speed.value, own});
  }
  function obey(act) {
    (told = true), act(), (time = scrub.valueAsNumber), (on = plays());
    setTimeout(() => (told = false), 50);
  }
  // It plays as it comes into view and rests as it leaves, until the reader uses the controls.
  function show(seen) {
    inView = seen;
    if (ready && !own && plays() !== inView) obey(() => button.click());
  }
  for (const event of ["click", "input", "keydown"]) addEventListener(event, ({isTrusted}) => (own ||= isTrusted), true);
  for (const [part, event] of [[scrub, "input"], [button, "click"], [speed, "change"]])
    part.addEventListener(event, () => setTimeout(tell));
  setInterval(() => {
    const [before, was] = [time, on];
    (time = scrub.valueAsNumber), (on = plays());
    if (on !== was || (on ? time < before : time !== before)) tell(); // by a key or a button, or from the start again
    if (!ready && (ready = document.documentElement.dataset.ready === "yes")) say({ready}), show(inView);
    const now = player.moment(), text = JSON.stringify(now);
    if (text !== last) (last = text), say({now});
  }, 100);
  addEventListener("message", ({data, source}) => {
    if (source !== parent) return;
    if (typeof data?.inView === "boolean") show(data.inView);
    if ("light" in (data ?? {})) player.light(data.light);
    if (typeof data?.seek === "number") (own = true), obey(() => (player.play(false), player.seek(data.seek)));
    if (typeof data?.time !== "number") return;
    own ||= data.own; // another one was used
    obey(() => {
      scrub.value = data.time;
      scrub.dispatchEvent(new Event("input"));
      if (data.speed !== speed.value && [...speed.options].some((option) => option.value === data.speed)) {
        speed.value = data.speed;
        speed.dispatchEvent(new Event("change"));
      }
      if (plays() !== data.plays) button.click();
    });
  });
  // A line of a curve or a kind of arrows that the reader points at.
  function pointed({target}) {
    const line = target.closest?.("#curves li"), layer = target.closest?.("[data-layer]")?.dataset.layer;
    if (line) return {curve: Number(line.closest("figure").dataset.curve), line: [...line.parentNode.children].indexOf(line)};
    return layer ? {arrow: layer} : null;
  }
  let at = "null";
  document.addEventListener("pointerover", (event) => {
    const found = pointed(event), text = JSON.stringify(found);
    if (text !== at) (at = text), say({pointed: found});
  });
})();
