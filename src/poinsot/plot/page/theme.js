"use strict";
// Colours on a light or a dark background, by the choice of the surrounding page or the preference of the system.

const theme = (() => {
  const prefers = matchMedia("(prefers-color-scheme: dark)");
  const ON_DARK = {
    "#000000": "#FFFFFF",
    "#0072B2": "#56B4E9",
    "#D55E00": "#FF8A3D",
    "#009E73": "#2CC79B",
    "#882255": "#E58BB5",
    "#332288": "#A99CF0",
    "#117733": "#5FC784",
    "#AA4499": "#DD93D4",
    "#999933": "#CFCF5E",
    "#6A3D9A": "#B79BDD",
  };
  const SPACE = "#05070B";
  const painters = [];
  let chosen = null;
  let inSpace = true;
  const isDark = () => (chosen ? chosen === "dark" : prefers.matches);
  const repaint = () => painters.forEach((paint) => paint());
  prefers.addEventListener("change", repaint);
  window.addEventListener("message", ({ source, data }) => {
    if (source !== window.parent || !["light", "dark"].includes(data?.theme)) return;
    chosen = document.documentElement.style.colorScheme = data.theme;
    repaint();
  });
  return {
    of: (colour) => (isDark() ? ON_DARK[colour] ?? colour : colour),
    /** A colour in the scene, whose ground is dark space or the ground of the page. */
    inScene: (colour) => (inSpace || isDark() ? ON_DARK[colour] ?? colour : colour),
    get sky() {
      return inSpace ? SPACE : this.ground;
    },
    get isSpace() {
      return inSpace;
    },
    /** Choose the ground of the scene: "space" or "plain". */
    setSky(name) {
      inSpace = name === "space";
      repaint();
    },
    get ground() {
      return isDark() ? "#15181C" : "#FFFFFF";
    },
    get ink() {
      return isDark() ? "#C8CDD3" : "#404040";
    },
    get grid() {
      return isDark() ? "#2E343B" : "#E3E3E3";
    },
    /** Call a function that uses colours, now and after each change of the choice or the preference. */
    paint(painter) {
      painters.push(painter);
      painter();
    },
  };
})();
