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
  const painters = [];
  let chosen = null;
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
