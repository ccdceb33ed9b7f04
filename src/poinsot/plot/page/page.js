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
  const sizes = document.querySelectorAll("#parts output");
  const size = (name, t) => Number(motion.norm(motion.vector(name, t)).toPrecision(4));
  for (const reading of sizes) reading.after(page.labels[reading.dataset.unit]);

  // ------------------------------------------------------------ scene and plots

  let scene = null;
  try {
    scene = sceneOf(motion, at("scene"));
  } catch (error) {
    console.error(error);
    at("space").textContent = "The body cannot be drawn: this browser has no WebGL.";
  }
  const plots = Array.from(document.querySelectorAll("#plots figure"), (figure) =>
    plotOf(figure, {
      times,
      values: motion.arrays[figure.id],
      colours: page.colours.components,
      label: page.labels[figure.id],
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
    slider.value = time;
    plots.forEach((plot) => plot.place(time));
    scene?.place(time);
    scene?.render();
  }

  function read() {
    at("now").textContent = `${page.labels.t} = ${short(Number(time.toPrecision(7)))}${page.labels.unit}`;
    for (const plot of plots) plot.read(motion.reading(plot.name, time));
    for (const reading of sizes) reading.textContent = short(size(reading.dataset.size, time));
  }

  // Where frames come slowly the picture has fewer dots while it moves, and all of them when it rests.

  // Numbers change as often as an eye can read them.

  const [SLOW, COARSEST, REST, READABLE] = [25, 0.4, 300, 100];
  let part = 1;
  let usual = 0;
  let drawn = -Infinity;
  let told = -Infinity;
  let rests = true;

  function adapt(gap) {
    if (rests) {
      part = Math.min(part * 1.5, 1);
    } else {
      usual = usual ? 0.8 * usual + 0.2 * gap : gap;
      if (usual < SLOW || part === COARSEST) return;
      part = Math.max(part * 0.8, COARSEST);
    }
    usual = 0;
    scene?.sharpen(part);
  }

  function frame(now) {
    if (playing) {
      if (before !== null) setTime(time + (Math.min(now - before, 250) / 1000) * Number(rate.value));
      before = now;
      if (time >= last) setPlaying(false);
    }
    if (changed) {
      adapt(now - drawn);
      [changed, rests, drawn] = [false, false, now];
      draw();
      if (!playing || now - told > READABLE) {
        read();
        told = now;
      }
    } else if (!rests && now - drawn > REST) {
      rests = true;
      scene?.sharpen(1);
      draw();
      read();
    }
    requestAnimationFrame(frame);
  }

  function resize() {
    scene?.resize();
    scene?.sharpen(1);
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
    for (const name of scene.solids) {
      at("solid").add(new Option(name === "inertia" ? "inertia ellipsoid" : name, name));
    }
    at("solid").addEventListener("change", (event) => {
      scene.show(event.target.value);
      changed = true;
    });
    for (const chooser of document.querySelectorAll("select[data-choice]")) {
      chooser.addEventListener("change", () => {
        scene[chooser.dataset.choice](chooser.value);
        changed = true;
      });
    }
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
  const views = {
    ArrowLeft: [-0.1, 0, 1],
    ArrowRight: [0.1, 0, 1],
    ArrowUp: [0, -0.1, 1],
    ArrowDown: [0, 0.1, 1],
    PageUp: [0, 0, 0.9],
    PageDown: [0, 0, 1 / 0.9],
  };
  document.addEventListener("keydown", (event) => {
    if (event.shiftKey && event.key in views && !event.target.closest("select")) {
      event.preventDefault();
      return scene?.turn(...views[event.key]);
    }
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
      const q = scene?.body?.quaternion;
      return q && [q.w, q.x, q.y, q.z];
    },
    get playing() {
      return playing;
    },
    /** Body, parts and paths as they are drawn, to be read. */
    get scene() {
      return scene;
    },
    /** The part of its dots with which the scene moves, from 0.4 to 1. */
    get sharpness() {
      return part;
    },
    setTime(t) {
      setTime(t);
      changed = false;
      draw();
      read();
    },
  };

  new ResizeObserver(resize).observe(at("stage"));
  resize();
  requestAnimationFrame(frame);
})();
