"use strict";
// The scene of one body of unit size, with its axes, vectors and the paths of their tips.

const BODY_AXIS = 1.35;
const LONGEST_OMEGA = 1.55;
const TAIL_TURNS = 10;

/** Return the scene; it draws itself at a time. */
function sceneOf(motion, canvas) {
  const { page, fine } = motion;
  const { solids, colours } = page;
  const stage = stageOf(canvas);
  const { scene } = stage;

  // ------------------------------------------------------------ the body and what turns with it

  const body = new THREE.Group();
  scene.add(body);
  const drawn = {};
  function add(name, solid) {
    drawn[name] = solid;
    solid.visible = false;
    body.add(solid);
  }
  const addPrincipal = (name, geometry, sides) => add(name, along(solids.principal, geometry, sides));
  if (solids.shape) add("shape", new THREE.Group().add(...solids.shape.map(part)));
  addPrincipal("ellipsoid", new THREE.SphereGeometry(1, 64, 48), solids.extent);
  addPrincipal("box", new THREE.BoxGeometry(2, 2, 2, 2, 2, 2), solids.extent);
  if (solids.inertia_ellipsoid) addPrincipal("inertia", new THREE.SphereGeometry(1, 96, 64), solids.inertia_ellipsoid);

  // ------------------------------------------------------------ axes, vectors, paths

  const parts = {
    space_axes: axes(scene, "s", SPACE_AXIS, colours.space_axes, 0.008),
    body_axes: axes(body, "b", BODY_AXIS, colours.body_axes, 0.012),
  };
  const G = new Arrow(scene, colours.angular_momentum, 0.016, "G");
  const omega = new Arrow(scene, colours.omega, 0.016, "ω");
  parts.angular_momentum = G.group;
  parts.omega = omega.group;

  const omegaBody = (t) => motion.vector("omega_body", t);
  const omegaSpace = (t) => motion.rotate(motion.quaternion(t), omegaBody(t));
  const paths = { polhode: path(omegaBody), herpolhode: path(omegaSpace) };
  const scaled = { polhode: new THREE.Group(), herpolhode: new THREE.Group() };
  body.add((parts.polhode = scaled.polhode));
  scene.add((parts.herpolhode = scaled.herpolhode));
  const most = TAIL_TURNS * 180;
  const tails = {};
  for (const name of ["polhode", "herpolhode"]) {
    scaled[name].add(whole(paths[name], colours[name], 0.4));
    tails[name] = new Tail(scaled[name], colours[name], 2.5, paths[name], most);
  }
  if (page.plane) scaled.herpolhode.add(plane(page.plane, colours.herpolhode));

  parts.trace = new THREE.Group();
  scene.add(parts.trace);
  const traces = [null, null, null];
  const axisTip = (k, t) =>
    motion.rotate(motion.quaternion(t), [0, 1, 2].map((i) => (i === k ? BODY_AXIS : 0)));
  let traced = 2;

  // ------------------------------------------------------------ what changes

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
    const rateInSpace = motion.rotate(q, rate);
    omega.point(rateInSpace, scale);
    const momentum = motion.vector("angular_momentum_space", t);
    G.point(momentum, LONGEST_MOMENTUM / page.largest.angular_momentum);
    const [end] = motion.place(t, fine);
    const [start] = motion.place(t - duration, fine);
    tails.polhode.draw(start, end, rate);
    tails.herpolhode.draw(start, end, rateInSpace);
    traces[traced].draw(start, end, axisTip(traced, t));
  }

  trace(traced);
  show(Object.keys(drawn)[0]);
  return { ...stage, body, drawn, parts, paths, tails, traces, solids: Object.keys(drawn), show, trace, place };
}

/** The invariable plane, a translucent disc across the angular momentum at the tip of omega. */
function plane({ normal, height, radius }, colour) {
  const disc = new THREE.Mesh(
    new THREE.CircleGeometry(radius, 96),
    new THREE.MeshBasicMaterial({
      color: colour,
      transparent: true,
      opacity: 0.1,
      side: THREE.DoubleSide,
      depthWrite: false,
    }),
  );
  disc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal));
  disc.position.set(...normal).multiplyScalar(height);
  return disc;
}
