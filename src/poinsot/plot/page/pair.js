"use strict";
// The scene of two bodies about their barycentre, to scale, with the paths of both and their surroundings.

const REACH = 1.85;
const BODY_AXIS = 1.35;
const RATE = 1.6;
const THICKEST = 0.012;
const NEAREST = 4;
const LEGIBLE = 0.05;

/** Return the scene, which draws itself at a time. */
function sceneOf(motion, canvas) {
  const { page, fine } = motion;
  const { colours } = page;
  const stage = stageOf(canvas);
  const { world, camera, controls } = stage;
  const length = REACH / page.reach;
  const near = new THREE.Group();
  world.add(near);
  const parts = { space_axes: axes(near, ["s₁", "s₂", "s₃"], SPACE_AXIS, colours.space_axes, SHAFT.space_axes) };
  for (const name of ["body_axes", "omega", "paths", "centres"]) near.add((parts[name] = new THREE.Group()));
  const G = new Arrow(near, colours.angular_momentum, SHAFT.momentum, "G");
  parts.angular_momentum = G.group;

  // ------------------------------------------------------------ the bodies

  const bodies = {};
  for (const [name, { share, radius, semiaxes, principal, shape }] of Object.entries(page.bodies)) {
    const size = radius * length;
    const thickness = Math.min(THICKEST, 0.05 * size);
    const drawn = { ellipsoid: along(principal, sphere(), semiaxes.map((x) => x * length)) };
    if (shape) drawn.shape = new THREE.Group().add(...shape.map(part));
    drawn.shape?.scale.setScalar(size);
    const body = new THREE.Group().add(...Object.values(drawn));
    near.add(body);
    const placed = (position) => position.map((x) => share * length * x);
    const points = path((t) => placed(motion.position(t)));
    parts.paths.add(whole(points, colours[name], 0.4));
    bodies[name] = {
      placed,
      size,
      drawn,
      body,
      points,
      tail: new Tail(parts.paths, colours[name], 2.5, points, fine.length),
      axes: axes(parts.body_axes, ["b₁", "b₂", "b₃"], BODY_AXIS * size, colours.body_axes, thickness),
      omega: new Arrow(parts.omega, colours.omega, 1.5 * thickness, "ω"),
    };
  }
  for (const each of Object.values(bodies)) {
    each.labels = [];
    for (const named of [each.axes, each.omega.group]) named.traverse((part) => part.isLabel && each.labels.push(part));
  }
  const line = whole(new Float32Array(6), colours.space_axes, 1);
  line.frustumCulled = false;
  parts.centres.add(line);
  const smallest = Math.min(...Object.values(bodies).map(({ size }) => size));
  controls.minDistance = NEAREST * smallest;
  camera.near = smallest;

  // ------------------------------------------------------------ surroundings and views

  const around = surroundingsOf(motion, { world, near, body: near, parts, lightFrom: stage.lightFrom });
  const ghosts = ghostsOf(page.ghosts, bodies);
  if (ghosts) near.add((parts.ghosts = ghosts.group));
  const own = { space: { words: "the barycentre" } };
  for (const [name, { body }] of Object.entries(bodies)) own[name] = { words: `the ${name}`, centre: () => body.position };
  const views = viewsOf(motion, stage, { near, far: around.far, own, usual: "space" });

  // ------------------------------------------------------------ frames

  const revolution = (2 * Math.PI) / page.mean_rate;

  function show(wanted) {
    for (const { drawn } of Object.values(bodies)) {
      const shown = wanted in drawn ? wanted : "ellipsoid";
      for (const [name, solid] of Object.entries(drawn)) solid.visible = name === shown;
    }
  }

  function place(t) {
    const position = motion.position(t);
    const [end] = motion.place(t, fine);
    const [start] = motion.place(t - revolution, fine);
    Object.entries(bodies).forEach(([name, { placed, body, size, axes, omega, tail }], k) => {
      const here = placed(position);
      const q = motion.quaternion(t, name);
      for (const each of [body, axes]) {
        each.position.set(...here);
        each.quaternion.copy(quaternion(q));
      }
      const rate = rotate(q, motion.vector(`${name}_omega_body`, t));
      omega.point(rate, (RATE * size) / page.largest[`${name}_omega_body`]);
      omega.group.position.set(...here);
      tail.draw(start, end, here);
      line.geometry.attributes.position.array.set(here, 3 * k);
    });
    line.geometry.attributes.position.needsUpdate = true;
    G.point(motion.vector("angular_momentum_space", t), LONGEST_MOMENTUM / page.largest.angular_momentum);
    around.place(t);
    ghosts?.place(t);
    views.place(t);
    for (const { body, size, labels } of Object.values(bodies)) {
      const legible = size > LEGIBLE * camera.position.distanceTo(body.getWorldPosition(new THREE.Vector3()));
      for (const label of labels) label.visible = legible;
    }
  }

  const solids = page.bodies.primary.shape || page.bodies.secondary.shape ? ["shape", "ellipsoid"] : ["ellipsoid"];
  show(solids[0]);
  return { ...stage, bodies, parts, around, ghosts, solids, views, show, look: views.look, place };
}
