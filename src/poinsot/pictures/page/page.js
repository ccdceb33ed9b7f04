"use strict";
// The controls, and the loop that draws a frame whenever something has changed.

(() => {
  const { page, times } = motion;
  const [first, last] = [times[0], times[times.length - 1]];
  const at = (id) => document.getElementById(id);
  const [slider, play, rate] = [at("time"), at("play"), at("rate")];
  let time = first;
  let playing = false;
  let changed = true;
  let before = null;

  at("title").textContent = page.title;
  at("note").textContent = page.note;
  at("note").hidden = !page.note;
  const sizes = { omega_body: at("omega"), angular_momentum_space: at("G") };
  const size = (name, t) => Number(motion.norm(motion.vector(name, t)).toPrecision(4));
  for (const [name, reading] of Object.entries(sizes)) reading.after(page.labels[name]);

  // ------------------------------------------------------------ scene and plots

  let scene = null;
  try {
    scene = sceneOf(motion, at("scene"));
  } catch (error) {
    console.error(error);
    at("space").textContent = "The body cannot be drawn: this browser has no WebGL.";
  }
  const plots = ["quaternion", "momenta"].map((name) =>
    plotOf(at(name), {
      times,
      values: motion.arrays[name],
      colours: page.colours.components,
      label: page.labels[name],
      timeLabel: page.labels.time,
    }),
  );

  // ------------------------------------------------------------ time

  function setTime(t) {
    time = Math.min(Math.max(Number(t), first), last);
    changed = true;
  }

  function setPlaying(wanted) {
    playing = wanted;
    before = null;
    if (playing && time >= last) setTime(first);
    play.textContent = playing ? "Pause" : "Play";
  }

  /** Go by stored times, forwards or backwards. */
  function step(count) {
    setPlaying(false);
    const [i, u] = motion.place(time);
    const here = u === 1 ? i + 1 : i;
    const from = count < 0 && u > 0 && u < 1 ? here + 1 : here;
    setTime(times[Math.min(Math.max(from + count, 0), times.length - 1)]);
  }

  function draw() {
    const t = time;
    slider.value = t;
    at("now").textContent = `${page.labels.t} = ${short(Number(t.toPrecision(7)))}${page.labels.unit}`;
    plots[0].place(t, motion.quaternion(t));
    plots[1].place(t, motion.momenta(t));
    for (const [name, reading] of Object.entries(sizes)) reading.textContent = short(size(name, t));
    scene?.place(t);
    scene?.render();
  }

  function frame(now) {
    if (playing) {
      if (before !== null) setTime(time + (Math.min(now - before, 250) / 1000) * Number(rate.value));
      before = now;
      if (time >= last) setPlaying(false);
    }
    if (changed) {
      changed = false;
      draw();
    }
    requestAnimationFrame(frame);
  }

  function resize() {
    scene?.resize();
    plots.forEach((plot) => plot.resize());
    changed = true;
  }

  // ------------------------------------------------------------ controls

  [slider.min, slider.max] = [first, last];
  slider.addEventListener("input", () => setTime(slider.valueAsNumber));
  play.addEventListener("click", () => setPlaying(!playing));

  for (const power of [-4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6]) {
    const perSecond = page.rate * 2 ** power;
    rate.add(new Option(`${short(Number(perSecond.toPrecision(3)))}${page.labels.unit} per second`, perSecond));
  }
  rate.selectedIndex = 4;

  if (scene) {
    const names = { mesh: "shape", ellipsoid: "ellipsoid", box: "box", inertia: "inertia ellipsoid" };
    for (const name of scene.solids) at("solid").add(new Option(names[name], name));
    at("solid").addEventListener("change", (event) => {
      scene.show(event.target.value);
      changed = true;
    });
    at("traced").addEventListener("change", (event) => {
      scene.trace(Number(event.target.value));
      changed = true;
    });
    for (const box of document.querySelectorAll("#parts input")) {
      const part = box.dataset.part;
      box.nextElementSibling.style.borderColor = page.colours[part];
      const toggle = () => {
        scene.parts[part].traverse((each) => each.layers.set(box.checked ? 0 : 1));
        changed = true;
      };
      box.addEventListener("change", toggle);
      toggle();
    }
    scene.controls.addEventListener("change", () => (changed = true));
  }

  for (const plot of plots) {
    const seek = (event) => event.buttons === 1 && setTime(plot.timeAt(event.clientX));
    plot.canvas.addEventListener("pointerdown", seek);
    plot.canvas.addEventListener("pointermove", seek);
  }

  const keys = {
    " ": () => setPlaying(!playing),
    ArrowRight: () => step(1),
    ArrowLeft: () => step(-1),
    Home: () => step(-times.length),
    End: () => step(times.length),
  };
  document.addEventListener("keydown", (event) => {
    const own = event.target.closest("select") || (event.key === " " && event.target.closest("button, [type=checkbox]"));
    if (own || event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys)) return;
    event.preventDefault();
    keys[event.key]();
  });

  window.poinsot = {
    get time() {
      return time;
    },
    /** Of the body in the scene, scalar first. */
    get quaternion() {
      const q = scene?.body.quaternion;
      return q && [q.w, q.x, q.y, q.z];
    },
    get playing() {
      return playing;
    },
    setTime(t) {
      setTime(t);
      changed = false;
      draw();
    },
  };

  new ResizeObserver(resize).observe(at("stage"));
  resize();
  requestAnimationFrame(frame);
})();
