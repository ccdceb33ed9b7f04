"use strict";
// The motion: arrays as stored, and what lies between them. Quaternions are scalar first, vectors plain arrays.

const motion = (() => {
  const page = JSON.parse(document.getElementById("motion").textContent);

  function bytes(base64) {
    return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
  }

  function unscaled({ data, scale }) {
    return Float64Array.from(new Float32Array(bytes(data)), (value) => value * scale);
  }

  const times = new Float64Array(bytes(page.times));
  const arrays = Object.fromEntries(Object.entries(page.arrays).map(([name, array]) => [name, unscaled(array)]));
  const last = times.length - 1;
  const STEP = arrays.position ? Math.PI / 90 : Math.PI / 30;

  /** The interval i of a time, and how far into it the time is: [i, 0..1]. */
  function place(t, grid = times) {
    let low = 0;
    let high = grid.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (grid[middle] <= t) low = middle;
      else high = middle;
    }
    return [low, Math.min(Math.max((t - grid[low]) / (grid[high] - grid[low]), 0), 1)];
  }

  function row(name, i) {
    const [out, size] = [[], arrays[name].length / times.length];
    for (let k = size * i; k < size * (i + 1); k++) out.push(arrays[name][k]);
    return out;
  }

  function dot(a, b) {
    let sum = 0;
    for (let k = 0; k < a.length; k++) sum += a[k] * b[k];
    return sum;
  }

  function mix(a, b, u, v) {
    const out = [];
    for (let k = 0; k < a.length; k++) out.push(u * a[k] + v * b[k]);
    return out;
  }

  function norm(a) {
    return Math.sqrt(dot(a, a));
  }

  /** 1, or -1 where the two ends of an interval have quaternions on opposite sides of the sphere. */
  function sign(i, name = "quaternion") {
    return dot(row(name, i), row(name, i + 1)) < 0 ? -1 : 1;
  }

  /** The quaternion on the great circle between the stored ones, of unit norm. */
  function quaternion(t, name = "quaternion") {
    const [i, u] = place(t);
    const a = row(name, i);
    const b = mix(row(name, i + 1), a, sign(i, name), 0);
    const angle = 2 * Math.atan2(norm(mix(a, b, 1, -1)), norm(mix(a, b, 1, 1)));
    const near = angle < 1e-9;
    const q = mix(a, b, near ? 1 - u : Math.sin((1 - u) * angle), near ? u : Math.sin(u * angle));
    return mix(q, q, 1 / norm(q), 0);
  }

  /** The conjugate momenta, linear between the stored ones. */
  function momenta(t) {
    const [i, u] = place(t);
    return mix(row("momenta", i), row("momenta", i + 1), 1 - u, u * sign(i));
  }

  /** A stored vector, linear between the times. */
  function vector(name, t) {
    const [i, u] = place(t);
    return mix(row(name, i), row(name, i + 1), 1 - u, u);
  }

  /** Of two bodies the secondary's position from the primary, on the cubic with the stored velocities. */
  function position(t) {
    const [i, u] = place(t);
    const span = times[i + 1] - times[i];
    const straight = mix(row("position", i), row("position", i + 1), (1 + 2 * u) * (1 - u) ** 2, u * u * (3 - 2 * u));
    const bent = mix(row("velocity", i), row("velocity", i + 1), u * (1 - u) ** 2 * span, u * u * (u - 1) * span);
    return mix(straight, bent, 1, 1);
  }

  /** What a plot shows at a time. */
  function reading(name, t) {
    const between = { quaternion, momenta, distance: (time) => [norm(position(time))] }[name];
    return between ? between(t) : vector(name, t);
  }

  /** Body to space: q v q~. */
  function rotate([w, x, y, z], [a, b, c]) {
    const [p, q, r] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
    return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
  }

  /**
   * How far it is from one stored time to the next, in radians: the turn of the body and the change of its rate, or of
   * two bodies the turn of the line of centres.
   */
  function distance(i) {
    if (arrays.position) {
      const [a, b] = [row("position", i), row("position", i + 1)];
      return Math.acos(Math.min(Math.max(dot(a, b) / (norm(a) * norm(b)), -1), 1));
    }
    const cosine = Math.min(Math.abs(dot(row("quaternion", i), row("quaternion", i + 1))), 1);
    const change = norm(mix(row("omega_body", i + 1), row("omega_body", i), 1, -1));
    return 2 * Math.acos(cosine) + change / page.largest.omega || 0;
  }

  /** Times at equal distances along the motion, a step apart, or 1e5 in all: what the curves go through. */
  function fineTimes() {
    const reached = new Float64Array(last + 1);
    for (let i = 0; i < last; i++) reached[i + 1] = reached[i] + distance(i);
    const count = Math.min(Math.ceil(reached[last] / STEP), 1e5) || 1;
    const fine = new Float64Array(count + 1);
    let i = 0;
    for (let k = 0; k < count; k++) {
      const goal = (reached[last] * k) / count;
      while (reached[i + 1] <= goal && i < last - 1) i++;
      const u = (goal - reached[i]) / (reached[i + 1] - reached[i]) || 0;
      fine[k] = times[i] + u * (times[i + 1] - times[i]);
    }
    fine[0] = times[0];
    fine[count] = times[last];
    return fine;
  }

  return { page, times, arrays, unscaled, place, quaternion, momenta, position, reading, vector, norm, rotate, fine: fineTimes() };
})();
