// Players side by side keep in step: what the reader tells one of them, the page around them tells the others.
(() => {
  const [scrub, button, speed] = ["scrub", "play", "speed"].map((id) => document.getElementById(id));
  if (!scrub || parent === window) return;
  const plays = () => button.getAttribute("aria-label") === "pause";
  let told = false;
  function tell() {
    const share = (scrub.valueAsNumber - scrub.min) / (scrub.max - scrub.min);
    if (!told) parent.postMessage({share, plays: plays(), speed: speed.value}, "*");
  }
  for (const [part, event] of [[scrub, "input"], [button, "click"], [speed, "change"]])
    part.addEventListener(event, () => setTimeout(tell));
  addEventListener("message", ({data, source}) => {
    if (source !== parent || typeof data?.share !== "number") return;
    told = true;
    scrub.value = Number(scrub.min) + data.share * (scrub.max - scrub.min);
    scrub.dispatchEvent(new Event("input"));
    if (data.speed !== speed.value && [...speed.options].some((option) => option.value === data.speed)) {
      speed.value = data.speed;
      speed.dispatchEvent(new Event("change"));
    }
    if (plays() !== data.plays) button.click();
    setTimeout(() => (told = false), 50);
  });
})();
