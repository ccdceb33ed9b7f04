"use strict";
// Controls of the drawn objects and of the view, and the keyboard.

/** Connect the controls of a scene, or remove them if there is none; `changed` is called after each choice. */
function connectScene(scene, changed) {
  const at = (id) => document.getElementById(id);
  const { page } = motion;
  const labels = document.querySelectorAll("#parts label");
  if (!scene) {
    at("views").remove();
    for (const label of labels) {
      label.querySelector("input, select")?.remove();
      if (!label.querySelector("output")) label.remove();
    }
    for (const group of document.querySelectorAll("details")) if (!group.querySelector("label")) group.remove();
    return;
  }

  for (const name of scene.solids) at("solid").add(new Option(name === "inertia" ? "inertia ellipsoid" : name, name));
  for (const [name, words] of Object.entries(scene.views.names)) at("view").add(new Option(words, name));
  at("view").value = scene.views.usual;
  for (const chooser of document.querySelectorAll("select[data-choice]")) {
    chooser.addEventListener("change", () => {
      scene[chooser.dataset.choice](chooser.value);
      changed();
    });
  }
  for (const box of document.querySelectorAll("#parts input")) {
    const { part } = box.dataset;
    theme.paint(() => (box.nextElementSibling.style.borderColor = theme.of(box.dataset.colour ?? page.colours[part])));
    const toggle = () => {
      scene.parts[part].traverse((each) => each.layers.set(box.checked ? 0 : 1));
      changed();
    };
    box.addEventListener("change", toggle);
    toggle();
  }
  theme.paint(() => at("labels").classList.toggle("plain", !theme.isSpace));
  scene.controls.addEventListener("change", changed);
  connectSaving(scene, changed);
}

function connectKeyboard(scene) {
  const keys = {
    " ": () => clock.setPlaying(!clock.playing),
    ArrowRight: () => clock.step(1),
    ArrowLeft: () => clock.step(-1),
    Home: () => clock.step(-motion.times.length),
    End: () => clock.step(motion.times.length),
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
    const own = event.target.closest("select") || (event.key === " " && event.target.closest("button, summary, [type=checkbox]"));
    if (own || event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys)) return;
    event.preventDefault();
    keys[event.key]();
  });
}
