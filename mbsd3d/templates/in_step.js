// Players side by side keep in step: what the reader tells one of them, the page around them tells the others. The one
// that is first at its end and starts anew takes them with it.
(() => {
  const [scrub, button, speed] = ["scrub", "play", "speed"].map((id) => document.getElementById(id));
  if (!scrub || parent === window) return;
  const plays = () => button.getAttribute("aria-label") === "pause";
  let told = false, time = scrub.valueAsNumber, on = plays();
  function tell() {
    if (!told) parent.postMessage({time: scrub.valueAsNumber, plays: plays(), speed: speed.value}, "*");
  }
  for (const [part, event] of [[scrub, "input"], [button, "click"], [speed, "change"]])
    part.addEventListener(event, () => setTimeout(tell));
  setInterval(() => {
    const [before, was] = [time, on];
    (time = scrub.valueAsNumber), (on = plays());
    if (on !== was || (on ? time < before : time !== before)) tell(); // by a key or a button, or from the start again
  }, 100);
  addEventListener("message", ({data, source}) => {
    if (source !== parent || typeof data?.time !== "number") return;
    told = true;
    scrub.value = data.time;
    scrub.dispatchEvent(new Event("input"));
    if (data.speed !== speed.value && [...speed.options].some((option) => option.value === data.speed)) {
      speed.value = data.speed;
      speed.dispatchEvent(new Event("change"));
    }
    if (plays() !== data.plays) button.click();
    (time = scrub.valueAsNumber), (on = plays());
    setTimeout(() => (told = false), 50);
  });
})();
