"use strict";
// Vectors and quaternions as plain arrays; quaternions are scalar first.

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

function unit(a) {
  return mix(a, a, 1 / norm(a), 0);
}

function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

function product([a, ...v], [b, ...w]) {
  return [a * b - dot(v, w), ...mix(mix(w, v, a, b), cross(v, w), 1, 1)];
}

function conjugate([a, x, y, z]) {
  return [a, -x, -y, -z];
}

/** Body to space: q v q~. */
function rotate([w, ...axis], v) {
  const twice = mix(cross(axis, v), v, 2, 0);
  return mix(mix(v, twice, 1, w), cross(axis, twice), 1, 1);
}

/** The quaternion of a rotation vector. */
function turned(vector) {
  const angle = norm(vector);
  const part = angle < 1e-8 ? 0.5 : Math.sin(angle / 2) / angle;
  return [Math.cos(angle / 2), ...mix(vector, vector, part, 0)];
}

/** The attitude of three perpendicular axes in space. */
function attitudeOf([[a, b, c], [d, e, f], [g, h, i]]) {
  const traces = [a + e + i, a - e - i, e - a - i, i - a - e];
  const largest = traces.indexOf(Math.max(...traces));
  const rows = [
    [1 + traces[0], f - h, g - c, b - d],
    [f - h, 1 + traces[1], b + d, g + c],
    [g - c, b + d, 1 + traces[2], f + h],
    [b - d, g + c, f + h, 1 + traces[3]],
  ];
  return unit(rows[largest]);
}

/** The rotation vector from one attitude to another that is nearest to a guess. */
function turnOf(before, after, guess) {
  const [w, ...v] = product(conjugate(before), after);
  const size = norm(v);
  const axis = size > 1e-12 ? mix(v, v, 1 / size, 0) : norm(guess) ? unit(guess) : [0, 0, 1];
  const angle = 2 * Math.atan2(size, w);
  return mix(axis, axis, angle + 2 * Math.PI * Math.round((dot(guess, axis) - angle) / (2 * Math.PI)), 0);
}

/** Largest difference, radians, between a turn and the rates at both ends for which the rates are used. */
const CREDIBLE = 1;
/** The largest turn for which the rate of a rotation vector is used; it is infinite at a whole turn. */
const LARGEST_TURN = 5;

/**
 * The rotation vector at a fraction u of an interval, from the attitude before it: a cubic whose slopes are the rates
 * at both ends, body axes, times the length of the interval. The slope at the end is the derivative of a rotation
 * vector r for a rate w, w + r x w / 2 + (1 - |r|/2 cot |r|/2) r x (r x w) / r^2 (Bortz 1971).
 */
function between(before, after, start, end, u) {
  const mean = mix(start, end, 0.5, 0.5);
  const r = turnOf(before, after, mean);
  const angle = norm(r);
  if (angle > LARGEST_TURN || norm(mix(r, mean, 1, -1)) > CREDIBLE) return mix(r, r, u, 0);
  const across = cross(r, end);
  const factor = angle < 1e-3 ? 1 / 12 : (1 - angle / 2 / Math.tan(angle / 2)) / (angle * angle);
  const slope = mix(mix(end, across, 1, 0.5), cross(r, across), 1, factor);
  const ends = mix(start, slope, u * (1 - u) ** 2, u * u * (u - 1));
  return mix(r, ends, u * u * (3 - 2 * u), 1);
}
