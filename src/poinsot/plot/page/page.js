"use strict";
// The page: scene, plots and numbers, and the loop that draws a frame whenever something has changed.

(() => {
  const { page } = motion;
  const at = (id) => document.getElementById(id);
  const stacked = matchMedia("(max-width: 760px)");
  let changed = true;
  const change = () => (changed = true);

  at("title").textContent = page.title;
  at("note").textContent = page.note;
  at("note").hidden = !page.note;
  const sizes = document.querySelectorAll("#parts output");
  const size = (name, t) => norm(motion.vector(name, t));
  const factor = (name) => page.factors[name] ?? 1;
  const largest = (name) => motion.values(name).reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  const scales = new Map(Array.from(sizes, ({ dataset }) => [dataset.size, largest(dataset.size)]));
  for (const reading of sizes) reading.after(page.labels[reading.dataset.unit] ?? reading.dataset.unit);

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
      motion,
      name: figure.dataset.quantity,
      quantities: page.quantities,
      colours: page.colours.components,
      timeLabel: page.labels.time,
      timeFactor: page.factors.time,
      events: clock.events,
      changed: change,
    }),
  );

  function draw() {
    scene?.place(clock.time);
    scene?.render();
  }

  function mark() {
    at("time").value = clock.time;
    plots.forEach((plot) => plot.place(clock.time));
  }

  function read() {
    clock.read();
    for (const plot of plots) plot.read(clock.time);
    for (const reading of sizes) {
      const { size: name, unit } = reading.dataset;
      reading.textContent = short(size(name, clock.time) * factor(unit), 4, scales.get(name) * factor(unit));
    }
  }

  // If frames are slow, a moving picture has fewer dots, and a picture at rest all of them. The marks of time move only
  // when numbers change, as often as a reader can follow, because each move draws the whole page anew.

  const [SLOW, COARSEST, REST, READABLE] = [25, 0.36, 300, 100];
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
    clock.pass(now);
    if (changed) {
      adapt(now - drawn);
      [changed, rests, drawn] = [false, false, now];
      draw();
      const due = !clock.playing || now - told > READABLE;
      if (due || part === 1) mark();
      if (due) {
        read();
        told = now;
      }
    } else if (!rests && now - drawn > REST) {
      rests = true;
      scene?.sharpen(1);
      draw();
      mark();
      read();
      clock.keep();
    }
    requestAnimationFrame(frame);
  }

  function resize() {
    scene?.resize();
    scene?.sharpen(1);
    plots.forEach((plot) => plot.resize());
    clock.resize();
    change();
    // A page around this one can give a stacked page its whole height; side by side it fills any height.
    if (window.parent !== window) window.parent.postMessage({ height: stacked.matches ? at("stage").offsetHeight : 0 }, "*");
  }

  connectScene(scene, change);
  connectKeyboard(scene);
  for (const plot of plots) {
    const seek = (event) => event.buttons === 1 && clock.setTime(plot.timeAt(event.clientX));
    plot.canvas.addEventListener("pointerdown", seek);
    plot.canvas.addEventListener("pointermove", seek);
  }
  clock.heard(change);

  window.poinsot = {
    get time() {
      return clock.time;
    },
    /** Attitude of the body in the scene, scalar first. */
    get quaternion() {
      const q = scene?.body?.quaternion;
      return q && [q.w, q.x, q.y, q.z];
    },
    get playing() {
      return clock.playing;
    },
    /** Drawn body, parts and paths, for tests. */
    get scene() {
      return scene;
    },
    /** Fraction of the dots of a moving scene, from 0.36 to 1. */
    get sharpness() {
      return part;
    },
    setTime(t) {
      clock.setTime(t);
      changed = false;
      draw();
      mark();
      read();
      clock.keep();
    },
  };

  clock.followLink();
  new ResizeObserver(resize).observe(at("stage"));
  theme.paint(resize);
  requestAnimationFrame(frame);
})();
