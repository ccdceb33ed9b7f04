"use strict";
// Surroundings of a body or a pair: orbit and attractor, orbital frame, Sun and shadow, torques and other vectors.

/** Smallest distance of the attractor and smallest height above its surface, in sizes of the body. */
const FARTHEST = 12;
const HEIGHT = 2.4;
const MOST = 400;
/** Radius of an attractor of unknown size, as fraction of the least distance. */
const UNKNOWN = 0.08;
const ORBIT_POINTS = 240;
const SUN_LENGTH = 1.85;
const FRAME_LENGTH = 1.6;
const VECTOR_LENGTH = 1.5;
const LIT = { Earth: "#8FB8DE", Mars: "#D9A27E", Sun: "#F6D56B", Moon: "#C9C9C9" };
const USUAL = "#C9BFB2";

/** Return a function that draws the surroundings of a body or a pair at a time, if the motion contains them. */
function surroundingsOf(motion, { world, near, body, parts }) {
  const { around, colours } = motion.page;
  const drawn = [];
  const far = around.orbit && attracted(motion, world, parts);
  if (far) drawn.push(far.place);
  if (around.orbit?.moves) drawn.push(orbitFrame(near, parts, colours.orbit_frame));
  if (around.sun) drawn.push(sunlit(motion, near, parts, far));
  for (const { array, letter, colour, largest } of around.vectors) {
    const arrow = new Arrow(body, colour, SHAFT.vector, letter);
    parts[array] = arrow.group;
    drawn.push((t) => arrow.point(motion.vector(array, t), VECTOR_LENGTH / largest));
  }
  return { far, place: (t) => drawn.forEach((place) => place(t)) };
}

/** The axes of the orbit at a time, radial, transverse and normal, in space. */
function axesOfOrbit(t) {
  const position = motion.orbit(t);
  const normal = unit(cross(position, motion.vector("orbit_velocity", t)));
  const radial = unit(position);
  return [radial, cross(normal, radial), normal];
}

/** Orbit and attractor, to scale with each other; the body is larger. */
function attracted(motion, world, parts) {
  const { attractor, radius, nearest, farthest, mean_rate: rate } = motion.page.around.orbit;
  const free = nearest - (radius ?? 0);
  const scale = Math.min(Math.max(FARTHEST / farthest, free > 0 ? HEIGHT / free : 0), MOST / farthest);
  const far = new THREE.Group();
  world.add((parts.orbit = far));
  const size = (radius ?? UNKNOWN * nearest) * scale;
  const ball = new THREE.Group();
  const light = new THREE.Color(LIT[attractor] ?? USUAL);
  const halves = motion.page.around.orbit.lit ? [light, light.clone().multiplyScalar(0.35)] : [light, light];
  halves.forEach((colour, k) => {
    const half = new THREE.SphereGeometry(size, 128, 32, 0, 2 * Math.PI, k ? Math.PI / 2 : 0, Math.PI / 2);
    ball.add(new THREE.Mesh(half, new THREE.MeshLambertMaterial({ color: colour })));
  });
  const name = text(attractor, motion.page.colours.space_axes);
  name.position.z = 1.15 * size;
  far.add(ball, name);

  const line = whole(new Float32Array(3 * (ORBIT_POINTS + 1)), motion.page.colours.orbit, 0.9);
  line.frustumCulled = false;
  far.add(line);
  const [first, last] = [motion.times[0], motion.times[motion.times.length - 1]];
  const period = Math.min((2 * Math.PI) / rate, last - first);
  let drawnAt = -Infinity;

  /** The revolution around a time, within the times of the motion. */
  function revolution(t) {
    if (Math.abs(t - drawnAt) < period / ORBIT_POINTS) return;
    drawnAt = t;
    const start = Math.min(Math.max(t - period / 2, first), last - period);
    const points = line.geometry.attributes.position;
    for (let i = 0; i <= ORBIT_POINTS; i++) {
      const place = motion.orbit(start + (period * i) / ORBIT_POINTS);
      points.array.set(mix(place, place, scale, 0), 3 * i);
    }
    points.needsUpdate = true;
  }

  function place(t) {
    const here = motion.orbit(t);
    far.position.set(...mix(here, here, -scale, 0));
    revolution(t);
  }

  return { ball, name, size, scale, reach: farthest * scale, group: far, place };
}

function orbitFrame(near, parts, colour) {
  const frame = axes(near, ["r", "t", "n"], FRAME_LENGTH, colour, SHAFT.orbit_frame);
  parts.orbit_frame = frame;
  return (t) => frame.quaternion.copy(quaternion(attitudeOf(axesOfOrbit(t))));
}

/** The direction to the Sun, the lit side of the attractor, and the shadow behind it. */
function sunlit(motion, near, parts, far) {
  const arrow = new Arrow(near, motion.page.colours.sun, SHAFT.sun, "Sun");
  parts.sun = arrow.group;
  let shadow = null;
  const { lit, radius } = motion.page.around.orbit ?? {};
  if (lit && radius) {
    const look = { color: "#3A4654", transparent: true, opacity: 0.18, depthWrite: false };
    const length = 1.6 * far.reach;
    const tube = new THREE.CylinderGeometry(...[1.002, 1.002].map((k) => k * far.size), length, 128, 1, true).translate(0, -length / 2, 0);
    shadow = new THREE.Mesh(tube, new THREE.MeshBasicMaterial(look));
    far.group.add((parts.shadow = shadow));
  }
  return (t) => {
    const towards = unit(motion.vector("sun", t));
    arrow.point(towards, SUN_LENGTH);
    const turn = new THREE.Quaternion().setFromUnitVectors(UP, new THREE.Vector3(...towards));
    far?.ball.quaternion.copy(turn);
    shadow?.quaternion.copy(turn);
  };
}
