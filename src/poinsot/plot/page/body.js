"use strict";
// The scene of one body of unit size, with its axes, vectors and the paths of their tips.

const BODY_AXIS = 1.35;
const LONGEST_OMEGA = 1.55;
const TAIL_TURNS = 10;
/** Number of points of a thin curve at rest, half of them before the time; fewer if frames are slow. */
const THIN_POINTS = 6000;

/** Return the scene, which draws itself at a time. */
function sceneOf(motion, canvas) {
  const { page, fine } = motion;
  const { solids, colours } = page;
  const stage = stageOf(canvas);
  const { world } = stage;
  const near = new THREE.Group();
  world.add(near);

  // ------------------------------------------------------------ body and objects fixed in it

  const body = new THREE.Group();
  near.add(body);
  const drawn = {};
  function add(name, solid) {
    drawn[name] = solid;
    solid.visible = false;
    body.add(solid);
  }
  const addPrincipal = (name, geometry, sides) => add(name, along(solids.principal, geometry, sides));
  if (solids.shape) add("shape", new THREE.Group().add(...solids.shape.map(part)));
  if (page.around.facets) add("facets", facets(page.around.facets));
  addPrincipal("ellipsoid", sphere(), solids.extent);
  addPrincipal("box", new THREE.BoxGeometry(2, 2, 2, 2, 2, 2), solids.extent);
  if (solids.inertia_ellipsoid) addPrincipal("inertia", sphere(), solids.inertia_ellipsoid);

  // ------------------------------------------------------------ axes, vectors, paths

  const parts = {
    space_axes: axes(near, ["s₁", "s₂", "s₃"], SPACE_AXIS, colours.space_axes, SHAFT.space_axes),
    body_axes: axes(body, ["b₁", "b₂", "b₃"], BODY_AXIS, colours.body_axes, SHAFT.body_axes),
  };
  const G = new Arrow(near, colours.angular_momentum, SHAFT.momentum, "G");
  const omega = new Arrow(near, colours.omega, SHAFT.omega, "ω");
  parts.angular_momentum = G.group;
  parts.omega = omega.group;

  const omegaBody = (t) => motion.vector("omega_body", t);
  const omegaSpace = (t) => rotate(motion.quaternion(t), omegaBody(t));
  const paths = { polhode: path(omegaBody), herpolhode: path(omegaSpace) };
  const scaled = { polhode: new THREE.Group(), herpolhode: new THREE.Group() };
  body.add((parts.polhode = scaled.polhode));
  near.add((parts.herpolhode = scaled.herpolhode));
  const most = TAIL_TURNS * 180;
  const tails = {};
  const thin = {};
  for (const name of ["polhode", "herpolhode"]) {
    scaled[name].add((thin[name] = whole(paths[name], colours[name], 0.4)));
    tails[name] = new Tail(scaled[name], colours[name], 2.5, paths[name], most);
  }
  if (page.plane) scaled.herpolhode.add(plane(page.plane, colours.herpolhode));

  parts.trace = new THREE.Group();
  near.add(parts.trace);
  const traces = [null, null, null];
  const axisTip = (k, t) =>
    rotate(motion.quaternion(t), [0, 1, 2].map((i) => (i === k ? BODY_AXIS : 0)));
  let traced = 2;

  // ------------------------------------------------------------ surroundings and views

  const around = surroundingsOf(motion, { world, near, body, parts, lightFrom: stage.lightFrom });
  const ghosts = ghostsOf(page.ghosts, { "": { drawn } });
  if (ghosts) near.add((parts.ghosts = ghosts.group));
  const wheels = wheelsOf(motion);
  if (wheels) body.add((parts.wheels = wheels.group));
  const own = { space: { words: "space axes" }, body: { words: "the body", turn: (t) => motion.quaternion(t) } };
  const views = viewsOf(motion, stage, { near, far: around.far, own, usual: page.around.orbit?.moves ? "orbit" : "space" });

  // ------------------------------------------------------------ frames

  let scale = 1;
  const duration = (TAIL_TURNS * 2 * Math.PI) / page.mean_rate;

  function show(name) {
    for (const [key, solid] of Object.entries(drawn)) solid.visible = key === name;
    scale = name === "inertia" ? 1 / Math.max(...solids.inertia_ellipsoid) : LONGEST_OMEGA / page.largest.omega;
    if (!Number.isFinite(scale)) scale = 1;
    drawn.inertia?.scale.set(...solids.inertia_ellipsoid.map((side) => side * scale));
    for (const group of Object.values(scaled)) group.scale.setScalar(scale);
  }

  function trace(k) {
    traced = Number(k);
    traces[traced] ??= new Tail(parts.trace, colours.body_axes, 2, path((t) => axisTip(traced, t)), most);
    traces.forEach((tail, i) => tail && (tail.line.visible = i === traced));
  }

  function place(t) {
    const q = motion.quaternion(t);
    body.quaternion.set(q[1], q[2], q[3], q[0]);
    const rate = omegaBody(t);
    const rateInSpace = rotate(q, rate);
    omega.point(rateInSpace, scale);
    const momentum = motion.vector("angular_momentum_space", t);
    G.point(momentum, LONGEST_MOMENTUM / page.largest.angular_momentum);
    const [end] = motion.place(t, fine);
    const [start] = motion.place(t - duration, fine);
    const points = Math.round(THIN_POINTS * stage.sharpness ** 2);
    const from = Math.min(Math.max(end - Math.round(points / 2), 0), Math.max(fine.length - points, 0));
    for (const line of Object.values(thin)) line.geometry.setDrawRange(from, points);
    tails.polhode.draw(start, end, rate);
    tails.herpolhode.draw(start, end, rateInSpace);
    traces[traced].draw(start, end, axisTip(traced, t));
    around.place(t);
    ghosts?.place(t);
    wheels?.place(t);
    views.place(t);
  }

  const choice = ["shape", "facets", page.plane ? "inertia" : "ellipsoid"].find((name) => drawn[name]);
  const names = [choice, ...Object.keys(drawn).filter((name) => name !== choice)];
  trace(traced);
  show(choice);
  const made = { body, drawn, parts, paths, tails, traces, around, ghosts, solids: names, views };
  return { ...stage, ...made, show, trace, look: views.look, place };
}

/** The invariable plane, a translucent disc across the angular momentum at the tip of omega. */
function plane({ normal, height, radius }, colour) {
  const look = { transparent: true, opacity: 0.1, side: THREE.DoubleSide, depthWrite: false };
  const disc = new THREE.Mesh(
    new THREE.CircleGeometry(radius, 96),
    painted(new THREE.MeshBasicMaterial(look), colour),
  );
  disc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal));
  disc.position.set(...normal).multiplyScalar(height);
  return disc;
}
