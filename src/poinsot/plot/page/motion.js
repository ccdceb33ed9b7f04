"use strict";
// The motion: stored arrays and their interpolation. Quaternions are scalar first, vectors plain arrays.

/** Numbers from their text in base 64. */
const stored = (() => {
  const KINDS = { f4: Float32Array, i2: Int16Array };
  const bytes = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
  return {
    timesOf: (base64) => new Float64Array(bytes(base64)),
    unscaled: ({ data, scale, kind }) => Float64Array.from(new KINDS[kind](bytes(data)), (value) => value * scale),
  };
})();

function row(array, size, i) {
  const out = [];
  for (let k = size * i; k < size * (i + 1); k++) out.push(array[k]);
  return out;
}

/** Interpolation between the times of a motion, from its stored arrays. */
function motionOf(times, packed) {
  const arrays = Object.fromEntries(Object.entries(packed).map(([name, array]) => [name, stored.unscaled(array)]));

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

  /** A stored vector, linear between the times. */
  function vector(name, t) {
    const [array, [i, u]] = [arrays[name], place(t)];
    const size = array.length / times.length;
    return mix(row(array, size, i), row(array, size, i + 1), 1 - u, u);
  }

  /** An attitude at a time, on the cubic through the stored attitudes with the stored rates at both ends. */
  function quaternion(t, body = "") {
    const [quaternions, rates] = ["quaternion", "omega_body"].map((name) => arrays[body ? `${body}_${name}` : name]);
    const [i, u] = place(t);
    const h = times[i + 1] - times[i];
    const ends = [0, 1].map((k) => [row(quaternions, 4, i + k), mix(row(rates, 3, i + k), [0, 0, 0], h, 0)]);
    const [[before, start], [after, end]] = ends;
    return unit(product(before, turned(between(before, after, start, end, u))));
  }

  /** A position at a time, on the cubic through the stored positions with the stored velocities at both ends. */
  function cubic(places, velocities, t) {
    const [i, u] = place(t);
    const h = times[i + 1] - times[i];
    const straight = mix(row(places, 3, i), row(places, 3, i + 1), (1 + 2 * u) * (1 - u) ** 2, u * u * (3 - 2 * u));
    const bent = mix(row(velocities, 3, i), row(velocities, 3, i + 1), u * (1 - u) ** 2 * h, u * u * (u - 1) * h);
    return mix(straight, bent, 1, 1);
  }

  const position = (t) => cubic(arrays.position, arrays.velocity, t);
  const orbit = (t) => cubic(arrays.orbit_position, arrays.orbit_velocity, t);
  return { times, arrays, place, vector, quaternion, position, orbit };
}

const motion = (() => {
  const page = JSON.parse(document.getElementById("motion").textContent);
  const own = motionOf(stored.timesOf(page.times), page.arrays);
  const { times, arrays, vector, quaternion, position } = own;
  const last = times.length - 1;
  const STEP = arrays.position ? Math.PI / 90 : Math.PI / 30;

  /** Q = 2 (0, G) q. */
  const momenta = (q, G) => mix(product([0, ...G], q), q, 2, 0);

  /** The values of a plot at all stored times. */
  function values(name) {
    const made = {
      momenta: (i) => momenta(row(arrays.quaternion, 4, i), row(arrays.angular_momentum_space, 3, i)),
      distance: (i) => [norm(row(arrays.position, 3, i))],
    }[name];
    return made ? Float64Array.from(Array.from(times, (_, i) => made(i)).flat()) : arrays[name];
  }

  /** The least and the largest stored value in each column of a plot, for very many times. */
  function envelope(name) {
    const found = page.envelopes[name];
    return found && { low: stored.unscaled(found.low), high: stored.unscaled(found.high) };
  }

  /** The values of a plot at a time. */
  function reading(name, t) {
    const made = {
      quaternion: () => quaternion(t),
      momenta: () => momenta(quaternion(t), vector("angular_momentum_space", t)),
      distance: () => [norm(position(t))],
    }[name];
    return made ? made() : page.quantities[name].angles ? angles(name, t) : vector(name, t);
  }

  /** Stored angles, linear along the shorter way between the times, within half a turn. */
  function angles(name, t) {
    const [array, [i, u]] = [arrays[name], own.place(t)];
    const size = array.length / times.length;
    const within = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
    const next = row(array, size, i + 1);
    return row(array, size, i).map((angle, k) => within(angle + u * within(next[k] - angle)));
  }

  /**
   * Distance from one stored time to the next, in radians: the turn of the body and the change of its rate, or for two
   * bodies the turn of the line of centres.
   */
  function distance(i) {
    const [a, b] = [0, 1].map((k) => row(arrays.position ?? arrays.omega_body, 3, i + k));
    if (arrays.position) return Math.acos(Math.min(Math.max(dot(a, b) / (norm(a) * norm(b)), -1), 1));
    return norm(mix(a, b, 0.5, 0.5)) * (times[i + 1] - times[i]) + (norm(mix(b, a, 1, -1)) / page.largest.omega || 0);
  }

  /** Times of the points of curves, at equal distances along the motion: a step apart, or 1e5 in all. */
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

  return { ...own, ...stored, page, values, envelope, reading, fine: fineTimes() };
})();
