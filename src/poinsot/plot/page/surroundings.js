"use strict";
// Surroundings of a body or a pair: orbit and attractor, orbital frame, Sun and shadow, observer, torques and other vectors.

/** Smallest distance of the attractor and smallest height above its surface, in sizes of the body. */
const FARTHEST = 12;
const HEIGHT = 2.4;
const MOST = 400;
/** Radius of an attractor of unknown size, as fraction of the least distance. */
const UNKNOWN = 0.08;
const ORBIT_POINTS = 240;
const SUN_LENGTH = 1.85;
const OBSERVER_LENGTH = 1.85;
const FRAME_LENGTH = 1.6;
const VECTOR_LENGTH = 1.5;
const GROUND = { Earth: "#3E74A8", Mars: "#B06A45", Sun: "#F6D56B", Moon: "#8F8F8F", Venus: "#C9A55B", Jupiter: "#B79A78", Saturn: "#C8B07A" };
const USUAL = "#8D8577";
/** Dots of the map of an attractor, degrees between its lines, and the light of its night side. */
const [MAP, LINES, NIGHT] = [{ width: 4096, height: 2048 }, 15, 0.2];
const ORBIT_WIDTH = 2;

/** Return a function that draws the surroundings of a body or a pair at a time, if the motion contains them. */
function surroundingsOf(motion, { world, near, body, parts, lightFrom }) {
  const { around, colours } = motion.page;
  const drawn = [];
  const far = around.orbit && attracted(motion, world, parts);
  if (far) drawn.push(far.place);
  if (around.orbit?.moves) drawn.push(orbitFrame(near, parts, colours.orbit_frame));
  if (around.sun) drawn.push(sunlit(motion, near, body, parts, far, lightFrom));
  if (around.arrows.includes("observer")) drawn.push(observed(motion, near, parts));
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
  const { lit } = motion.page.around.orbit;
  const night = nightOf(size);
  const ball = new THREE.Group().add(globe(size, GROUND[attractor] ?? USUAL, lit));
  if (lit) ball.add(night);
  const name = new Label(attractor, motion.page.colours.space_axes);
  name.position.z = 1.15 * size;
  far.add(ball, name);

  const points = new Float32Array(3 * (ORBIT_POINTS + 1));
  const line = new Tail(far, motion.page.colours.orbit, ORBIT_WIDTH, points, ORBIT_POINTS);
  const [first, last] = [motion.times[0], motion.times[motion.times.length - 1]];
  const period = Math.min((2 * Math.PI) / rate, last - first);
  let drawnAt = -Infinity;

  /** The revolution around a time, within the times of the motion. */
  function revolution(t) {
    if (Math.abs(t - drawnAt) < period / ORBIT_POINTS) return;
    drawnAt = t;
    const start = Math.min(Math.max(t - period / 2, first), last - period);
    for (let i = 0; i <= ORBIT_POINTS; i++) {
      const place = motion.orbit(start + (period * i) / ORBIT_POINTS);
      points.set(mix(place, place, scale, 0), 3 * i);
    }
    line.follow(points);
  }

  function place(t) {
    const here = motion.orbit(t);
    far.position.set(...mix(here, here, -scale, 0));
    revolution(t);
  }

  return { ball, night, name, size, scale, reach: farthest * scale, group: far, place };
}

function orbitFrame(near, parts, colour) {
  const frame = axes(near, ["r", "t", "n"], FRAME_LENGTH, colour, SHAFT.orbit_frame);
  parts.orbit_frame = frame;
  return (t) => frame.quaternion.copy(quaternion(attitudeOf(axesOfOrbit(t))));
}

/** A globe with lines of longitude and latitude about the third space axis; lit by the Sun it has a night side. */
function globe(size, colour, lit) {
  const map = document.createElement("canvas");
  const pen = Object.assign(map, MAP).getContext("2d");
  [pen.fillStyle, pen.lineWidth] = [colour, 2];
  pen.fillRect(0, 0, map.width, map.height);
  const step = (LINES / 360) * map.width;
  for (let k = 0; k <= 360 / LINES; k++) {
    const [along, across] = [k * step, k * LINES === 90];
    pen.strokeStyle = across ? "#ffffffb0" : "#ffffff58";
    for (const [from, to] of [[[along, 0], [along, map.height]], [[0, along], [map.width, along]]]) {
      pen.beginPath();
      pen.moveTo(...from);
      pen.lineTo(...to);
      pen.stroke();
    }
  }
  const texture = new THREE.CanvasTexture(map);
  [texture.colorSpace, texture.anisotropy] = ["srgb", 8];
  const geometry = new THREE.SphereGeometry(size, 128, 64).rotateX(Math.PI / 2);
  return new THREE.Mesh(geometry, lit ? new THREE.MeshBasicMaterial({ map: texture }) : new THREE.MeshLambertMaterial({ map: texture }));
}

/** The night side of a globe, whose second axis points to the Sun: a dark veil, the denser the lower the Sun is. */
function nightOf(size) {
  const geometry = new THREE.SphereGeometry(1.001 * size, 128, 64);
  const height = geometry.attributes.position;
  const veil = new Float32Array(4 * height.count);
  for (let i = 0; i < height.count; i++) {
    const light = Math.max(height.array[3 * i + 1] / (1.001 * size), 0);
    veil.set([0, 0, 0.004, (1 - NIGHT) * (1 - light ** 0.7)], 4 * i);
  }
  geometry.setAttribute("color", new THREE.BufferAttribute(veil, 4));
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }));
}

/** The direction to the Sun, its light on the body and on the attractor, and the shadow behind that. */
function sunlit(motion, near, body, parts, far, lightFrom) {
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
  const painted = [];
  body.traverse((part) => part.material?.isMeshLambertMaterial && painted.push(part.material));
  return (t) => {
    const towards = unit(motion.vector("sun", t));
    arrow.point(towards, SUN_LENGTH);
    lightFrom(towards);
    const share = motion.arrays.sunlight ? motion.vector("sunlight", t)[0] : 1;
    for (const material of painted) material.color.setScalar(IN_SHADOW + (1 - IN_SHADOW) * share);
    const turn = new THREE.Quaternion().setFromUnitVectors(UP, new THREE.Vector3(...towards));
    far?.night.quaternion.copy(turn);
    shadow?.quaternion.copy(turn);
  };
}

/** The direction to the observer. */
function observed(motion, near, parts) {
  const arrow = new Arrow(near, motion.page.colours.observer, SHAFT.observer, "observer");
  parts.observer = arrow.group;
  return (t) => arrow.point(unit(motion.vector("observer", t)), OBSERVER_LENGTH);
}

/** Brightness of the body in the shadow of the attractor. */
const IN_SHADOW = 0.6;
