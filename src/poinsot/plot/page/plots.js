"use strict";
// Plots against time next to the scene, drawn once for a size, under a cursor that follows the time.

const EVENTS = motion.page.colours.events;
/** Relative change below which a change is rounding, which a plot does not enlarge. */
const ROUNDING = 1e-5;
/** Fraction of the largest value below which a value is rounding and reads 0. */
const NEGLIGIBLE = 1e-11;

/** Round numbers, about `count` of them, within [low, high]. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) out.push(k * step);
  return out;
}

/** A number as text; relative to a given scale, rounding reads 0. */
function short(value, digits = 6, scale = 0) {
  const size = Math.abs(value);
  if (size < NEGLIGIBLE * scale) return "0";
  if (size !== 0 && (size >= 1e5 || size < 1e-3)) return value.toExponential(1).replace("e+", "e").replaceAll("-", "−");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/**
 * Return one plot in a figure, of the quantity that the reader chooses. `quantities` have, by name, a label, symbols of
 * the components, and the factor from the numbers of the motion to the unit of the label.
 */
function plotOf(figure, { motion, name, quantities, colours, timeLabel, timeFactor, events, changed }) {
  const canvas = figure.querySelector("canvas");
  const cursor = figure.querySelector(".cursor");
  const chooser = figure.querySelector("select");
  const { times } = motion;
  const [first, last] = [times[0], times[times.length - 1]];
  const box = { left: 58, right: 10, top: 6, bottom: 36, width: 0, height: 0 };
  const x = (t) => box.left + ((t - first) / (last - first)) * box.width;
  const y = (value) => box.top + ((high - value) / (high - low)) * box.height;
  let values, envelope, factor, size, low, high, largest, readings;

  for (const [each, { label }] of Object.entries(quantities)) chooser.add(new Option(label, each));
  chooser.addEventListener("change", () => {
    choose(chooser.value);
    resize();
    changed();
  });

  /** Show another quantity: n rows of as many components as it has symbols. */
  function choose(wanted) {
    name = chooser.value = figure.dataset.quantity = wanted;
    const { label, symbols } = quantities[name];
    [values, envelope, factor, size] = [motion.values(name), motion.envelope(name), quantities[name].factor, symbols.length];
    [low, high] = [Infinity, -Infinity];
    for (const value of envelope ? [...envelope.low, ...envelope.high] : values) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    largest = Math.max(Math.abs(low), Math.abs(high));
    const [least, most] = [low, high].map((value) => short(factor * value, 6, factor * largest));
    canvas.setAttribute("aria-label", `${label} against ${timeLabel}, between ${least} and ${most}`);
    const room = Math.max(0.07 * (high - low), ROUNDING * largest) || 1;
    [low, high] = [low - room, high + room];
    const row = figure.querySelector(".values");
    row.replaceChildren(
      ...symbols.map((symbol, k) => {
        const [item, letter] = ["span", "i"].map((tag) => document.createElement(tag));
        letter.textContent = symbol;
        item.append(letter, " ", document.createElement("output"));
        item.style.borderColor = theme.of(colours[k]);
        return item;
      }),
    );
    readings = Array.from(row.querySelectorAll("output"));
  }
  theme.paint(() => readings?.forEach((reading, k) => (reading.parentElement.style.borderColor = theme.of(colours[k]))));

  function frame(pen) {
    pen.font = "11px system-ui, sans-serif";
    [pen.strokeStyle, pen.fillStyle, pen.lineWidth] = [theme.grid, theme.ink, 1];
    pen.textAlign = "center";
    for (const shown of ticks(timeFactor * first, timeFactor * last, box.width / 80)) {
      const t = shown / timeFactor;
      line(pen, [x(t), box.top], [x(t), box.top + box.height]);
      const [label, edge] = [short(shown), box.left + box.width + box.right];
      pen.fillText(label, Math.min(x(t), edge - pen.measureText(label).width / 2), box.top + box.height + 14);
    }
    pen.fillText(timeLabel, box.left + box.width / 2, box.top + box.height + 30);
    [pen.textAlign, pen.textBaseline] = ["right", "middle"];
    const levels = ticks(factor * low, factor * high, Math.max(box.height / 36, 4));
    const digits = Math.max(6, Math.ceil(Math.log10((factor * Math.max(-low, high)) / (levels[1] - levels[0]))) + 1) || 6;
    for (const shown of levels) {
      const here = y(shown / factor);
      line(pen, [box.left, here], [box.left + box.width, here]);
      pen.fillText(short(shown, digits), box.left - 6, here);
    }
    pen.strokeStyle = theme.of(EVENTS);
    for (const { t } of events) line(pen, [x(t), box.top], [x(t), box.top + 6]);
    pen.strokeStyle = "#8C8C8C";
    pen.strokeRect(box.left, box.top, box.width, box.height);
  }

  function line(pen, from, to) {
    pen.beginPath();
    pen.moveTo(...from);
    pen.lineTo(...to);
    pen.stroke();
  }

  /** One component. */
  function curve(pen, k) {
    [pen.strokeStyle, pen.lineWidth, pen.lineJoin] = [theme.of(colours[k]), 1.3, "round"];
    pen.beginPath();
    if (envelope) band(pen, k);
    else samples(pen, k);
    pen.stroke();
  }

  /** Draw from the least to the largest value of each column. */
  function band(pen, k) {
    const count = envelope.low.length / size;
    for (let i = 0; i < count; i++) {
      const here = box.left + ((i + 0.5) / count) * box.width;
      pen.lineTo(here, y(envelope.low[size * i + k]));
      pen.lineTo(here, y(envelope.high[size * i + k]));
    }
  }

  /** Return the first, least, largest and last sample of each column of pixels. */
  function samples(pen, k) {
    const value = (i) => values[size * i + k];
    const column = (i) => Math.floor(2 * x(times[i]));
    for (let i = 0; i < times.length; ) {
      const kept = [i, i, i, i];
      const here = column(i);
      for (; i < times.length && column(i) === here; i++) {
        if (value(i) < value(kept[1])) kept[1] = i;
        if (value(i) > value(kept[2])) kept[2] = i;
        kept[3] = i;
      }
      for (const j of kept.sort((one, other) => one - other)) pen.lineTo(x(times[j]), y(value(j)));
    }
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    const ratio = window.devicePixelRatio;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    [box.width, box.height] = [width - box.left - box.right, height - box.top - box.bottom];
    const pen = canvas.getContext("2d", { alpha: false }); // an opaque canvas is drawn faster
    pen.scale(ratio, ratio);
    pen.fillStyle = theme.ground;
    pen.fillRect(0, 0, width, height);
    frame(pen);
    for (let k = 0; k < size; k++) curve(pen, k);
    [cursor.style.top, cursor.style.height] = [`${canvas.offsetTop + box.top}px`, `${box.height}px`];
  }

  function timeAt(clientX) {
    const u = (clientX - canvas.getBoundingClientRect().left - box.left) / box.width;
    return first + Math.min(Math.max(u, 0), 1) * (last - first);
  }

  function place(t) {
    cursor.style.transform = `translateX(${x(t)}px)`;
  }

  function read(t) {
    const components = motion.reading(name, t);
    readings.forEach((reading, k) => (reading.textContent = short(factor * components[k], 3, factor * largest)));
  }

  choose(name);
  return { canvas, choose, resize, place, read, timeAt };
}
