"use strict";
// Time: playback, time line, events, dates, and the part of a link that contains the time.

const clock = (() => {
  const { page, times } = motion;
  const [first, last] = [times[0], times[times.length - 1]];
  const at = (id) => document.getElementById(id);
  const [slider, play, rate, loop, marks] = ["time", "play", "rate", "loop", "marks"].map(at);
  const THUMB = 8;
  const listeners = [];
  let time = first;
  let playing = false;
  let before = null;

  function setTime(t) {
    time = Math.min(Math.max(Number(t), first), last);
    listeners.forEach((hear) => hear());
  }

  function setPlaying(wanted) {
    playing = wanted;
    before = null;
    if (playing && time >= last) setTime(first);
    play.textContent = playing ? "Pause" : "Play";
  }

  /** Step by stored times, forwards or backwards. */
  function step(count) {
    setPlaying(false);
    const [i, u] = motion.place(time);
    const here = u === 1 ? i + 1 : i;
    const from = count < 0 && u > 0 && u < 1 ? here + 1 : here;
    setTime(times[Math.min(Math.max(from + count, 0), times.length - 1)]);
  }

  /** Advance the time to a frame at a reading of the browser's clock, in milliseconds. */
  function pass(now) {
    if (!playing) return;
    if (before !== null) setTime(time + (Math.min(now - before, 250) / 1000) * Number(rate.value));
    before = now;
    if (time < last) return;
    if (loop.checked) setTime(first);
    else setPlaying(false);
  }

  // ------------------------------------------------------------ texts

  const shown = (t, digits = 7) => short(page.factors.time * t, Math.min(digits, 6), 0, digits);
  const inWords = (t = time) => `${page.labels.t} = ${shown(t)}${page.labels.unit}`;

  function date() {
    if (!page.calendar) return "";
    const { zero, unit, scale } = page.calendar;
    const instant = new Date(zero + time * unit);
    if (Number.isNaN(instant.getTime())) return "";
    const digits = (last - first) * unit < 60_000 ? 23 : 19;
    return `${instant.toISOString().slice(0, digits).replace("T", " ")} ${scale}`;
  }

  function read() {
    const words = [inWords(), date()];
    [at("now").textContent, at("date").textContent] = words;
    slider.setAttribute("aria-valuetext", words.filter(Boolean).join(", "));
  }

  /** Put the time into the address of the page; browsers refuse many of these in a row. */
  function keep() {
    if (location.protocol !== "about:") history.replaceState(null, "", `#t=${Number(time.toPrecision(12))}`);
  }

  function followLink() {
    const said = Number(/^#t=(.+)$/.exec(location.hash)?.[1]);
    if (Number.isFinite(said)) setTime(said);
  }

  // ------------------------------------------------------------ controls

  const POWERS = [-4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6];
  for (const power of POWERS) {
    const perSecond = page.rate * 2 ** power;
    rate.add(new Option(`${shown(perSecond, 3)}${page.labels.unit} per second`, perSecond));
  }
  rate.selectedIndex = POWERS.indexOf(0);
  if (page.second) rate.add(new Option("real time", page.second));
  [slider.min, slider.max] = [first, last];
  slider.addEventListener("input", () => setTime(slider.valueAsNumber));
  play.addEventListener("click", () => setPlaying(!playing));
  window.addEventListener("hashchange", followLink);

  /** Each time of an event, with its name. */
  const events = page.events.flatMap(({ name, times: all, directions }) =>
    all.map((t, i) => ({ t, name: `${name} ${directions[i] > 0 ? "↑" : "↓"}` })),
  );
  events.sort((one, other) => one.t - other.t);
  const [happened, chosen] = [at("happened"), at("event")];
  happened.hidden = marks.hidden = !events.length;
  chosen.add(new Option("go to ...", ""));
  for (const { t, name } of events) chosen.add(new Option(`${shown(t)}  ${name}`, t));
  chosen.addEventListener("change", () => chosen.value && setTime(chosen.value));

  function resize() {
    const [width, ratio] = [slider.clientWidth, window.devicePixelRatio];
    [marks.width, marks.height] = [Math.round(width * ratio), Math.round(8 * ratio)];
    const pen = marks.getContext("2d");
    pen.fillStyle = theme.of(page.colours.events);
    for (const { t } of events) {
      const x = THUMB + ((t - first) / (last - first)) * (width - 2 * THUMB);
      pen.fillRect((x - 1) * ratio, 0, 2 * ratio, marks.height);
    }
  }

  const own = { setTime, setPlaying, step, pass, read, keep, resize, followLink, inWords, events };
  return Object.defineProperties(own, {
    time: { get: () => time },
    playing: { get: () => playing },
    /** Time of the motion that passes in a second. */
    rate: { get: () => Number(rate.value) },
    heard: { value: (hear) => listeners.push(hear) },
  });
})();
