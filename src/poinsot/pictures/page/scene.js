"use strict";
// The scene in three dimensions: the body of unit size, axes, vectors and the paths of their tips.

const BODY_AXIS = 1.35;
const SPACE_AXIS = 1.75;
const LONGEST_OMEGA = 1.55;
const LONGEST_MOMENTUM = 1.95;
const TAIL_TURNS = 10;
const LIGHT = "#D3E0EA";
const SHADE = "#9DB6C9";

/** A fat line through at most `most` points, of which the last ones are drawn. */
class Tail {
  constructor(parent, colour, width, most) {
    this.geometry = new THREE.LineSegmentsGeometry().setPositions(new Float32Array(6 * most));
    this.buffer = this.geometry.attributes.instanceStart.data;
    this.most = most;
    this.line = new THREE.LineSegments2(
      this.geometry,
      new THREE.LineMaterial({ color: colour, linewidth: width, polygonOffset: true, polygonOffsetFactor: -2 }),
    );
    this.line.frustumCulled = false;
    parent.add(this.line);
  }

  /** Draw the points first..last of a path, then the tip. */
  draw(path, first, last, tip) {
    const from = Math.max(first, last - this.most + 1);
    let [x, y, z] = path.subarray(3 * from, 3 * from + 3);
    let n = 0;
    const join = (a, b, c) => {
      this.buffer.array.set([x, y, z, a, b, c], 6 * n++);
      [x, y, z] = [a, b, c];
    };
    for (let i = from + 1; i <= last; i++) join(path[3 * i], path[3 * i + 1], path[3 * i + 2]);
    join(...tip);
    this.buffer.needsUpdate = true;
    this.geometry.instanceCount = n;
  }
}

/** An arrow from the origin whose length is set with its tip; too short to have a head, it is hidden. */
class Arrow {
  constructor(parent, colour, width, label) {
    const material = new THREE.MeshBasicMaterial({ color: colour });
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(width, width, 1, 12), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(3.2 * width, 9 * width, 20), material);
    this.head_length = 9 * width;
    this.label = text(label, colour);
    this.group = new THREE.Group().add(this.shaft, this.head, this.label);
    parent.add(this.group);
  }

  point(tip) {
    const length = Math.hypot(...tip);
    this.group.visible = length > 1e-6;
    if (!this.group.visible) return;
    const head = Math.min(this.head_length, length / 2);
    this.group.quaternion.setFromUnitVectors(
      new THREE.Vector3(0, 1, 0),
      new THREE.Vector3(...tip.map((x) => x / length)),
    );
    this.shaft.scale.y = length - head;
    this.shaft.position.y = (length - head) / 2;
    this.head.scale.y = head / this.head_length;
    this.head.position.y = length - head / 2;
    this.label.position.y = length + 0.12;
  }
}

/** A word that faces the eye. */
function text(words, colour) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [128, 64];
  const pen = canvas.getContext("2d");
  pen.font = "italic 600 44px Georgia, 'DejaVu Serif', serif";
  [pen.textAlign, pen.textBaseline, pen.lineWidth] = ["center", "middle", 8];
  [pen.strokeStyle, pen.fillStyle] = ["rgba(255, 255, 255, 0.85)", colour];
  pen.strokeText(words, 64, 32);
  pen.fillText(words, 64, 32);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = "srgb";
  return new THREE.Sprite(new THREE.SpriteMaterial({ map, depthWrite: false, sizeAttenuation: false }));
}

function axes(parent, letter, length, colour, width) {
  const group = new THREE.Group();
  for (let k = 0; k < 3; k++) {
    const arrow = new Arrow(group, colour, width, letter + "₁₂₃"[k]);
    arrow.point([0, 1, 2].map((i) => (i === k ? length : 0)));
  }
  parent.add(group);
  return group;
}

/** A solid whose octants alternate between two shades, so that every turn is seen. */
function shaded(geometry) {
  const [light, shade] = [new THREE.Color(LIGHT), new THREE.Color(SHADE)];
  const flat = geometry.index ? geometry.toNonIndexed() : geometry;
  const place = flat.attributes.position;
  const colours = new Float32Array(3 * place.count);
  for (let i = 0; i < place.count; i += 3) {
    const middle = [0, 1, 2].map((k) => place.array[3 * i + k] + place.array[3 * i + 3 + k] + place.array[3 * i + 6 + k]);
    const colour = middle[0] * middle[1] * middle[2] > 0 ? light : shade;
    for (let k = 0; k < 3; k++) colour.toArray(colours, 3 * (i + k));
  }
  flat.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return new THREE.Mesh(flat, new THREE.MeshLambertMaterial({ vertexColors: true }));
}

/** Triangles, three vertices each, with sharp edges. */
function mesh(corners) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(corners), 3));
  geometry.computeVertexNormals();
  return shaded(geometry);
}

/** Return the scene; it draws itself at a time. */
function sceneOf(motion, canvas) {
  const { page, fine } = motion;
  const { solids, colours } = page;
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(32, 1, 0.1, 100);
  camera.up.set(0, 0, 1);
  camera.position.set(3.4, -5.6, 2.6);
  const controls = new THREE.OrbitControls(camera, canvas);
  controls.enablePan = false;
  [controls.minDistance, controls.maxDistance] = [2, 30];
  const sun = new THREE.DirectionalLight("#ffffff", 2.2);
  sun.position.set(-1.5, 1.5, 3);
  camera.add(sun);
  scene.add(new THREE.AmbientLight("#ffffff", 1.6), camera);

  // ------------------------------------------------------------ the body and what turns with it

  const body = new THREE.Group();
  scene.add(body);
  const principal = new THREE.Quaternion(...[1, 2, 3, 0].map((k) => solids.principal[k]));
  const drawn = {};
  function add(name, solid) {
    drawn[name] = solid;
    solid.visible = false;
    body.add(solid);
  }
  function addPrincipal(name, geometry, sides) {
    const solid = shaded(geometry);
    solid.quaternion.copy(principal);
    solid.scale.set(...sides);
    Object.assign(solid.material, { transparent: true, opacity: 0.7 });
    add(name, solid);
  }
  if (solids.mesh) add("mesh", mesh(motion.unscaled(solids.mesh)));
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

  function path(point) {
    const out = new Float32Array(3 * fine.length);
    fine.forEach((t, i) => out.set(point(t), 3 * i));
    return out;
  }
  function whole(points, colour, opacity) {
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3));
    return new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
  }
  const omegaBody = (t) => motion.vector("omega_body", t);
  const omegaSpace = (t) => motion.rotate(motion.quaternion(t), omegaBody(t));
  const paths = { polhode: path(omegaBody), herpolhode: path(omegaSpace) };
  const scaled = { polhode: new THREE.Group(), herpolhode: new THREE.Group() };
  body.add((parts.polhode = scaled.polhode));
  scene.add((parts.herpolhode = scaled.herpolhode));
  const most = 2 * TAIL_TURNS * 90;
  const tails = {};
  for (const name of ["polhode", "herpolhode"]) {
    scaled[name].add(whole(paths[name], colours[name], 0.4));
    tails[name] = new Tail(scaled[name], colours[name], 2.5, most);
  }
  if (page.plane) scaled.herpolhode.add(plane(page.plane, colours.herpolhode));

  parts.trace = new THREE.Group();
  scene.add(parts.trace);
  tails.trace = new Tail(parts.trace, colours.body_axes, 2, most);
  const traces = [0, 1, 2].map(() => null);
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
    traced = k;
    traces[k] ??= path((t) => axisTip(k, t));
  }

  function place(t) {
    const q = motion.quaternion(t);
    body.quaternion.set(q[1], q[2], q[3], q[0]);
    const rate = omegaBody(t);
    const rateInSpace = motion.rotate(q, rate);
    omega.point(rateInSpace.map((x) => x * scale));
    const momentum = motion.vector("angular_momentum_space", t);
    G.point(momentum.map((x) => (x * LONGEST_MOMENTUM) / page.largest.angular_momentum || 0));
    const [end] = motion.place(t, fine);
    const [start] = motion.place(t - duration, fine);
    tails.polhode.draw(paths.polhode, start, end, rate);
    tails.herpolhode.draw(paths.herpolhode, start, end, rateInSpace);
    tails.trace.draw(traces[traced], start, end, axisTip(traced, t));
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.zoom = Math.min(1, camera.aspect * 0.97);
    camera.updateProjectionMatrix();
    const label = 36 / height / camera.zoom;
    scene.traverse((part) => part.isSprite && part.scale.set(2 * label * 0.57, label * 0.57, 1));
  }

  trace(traced);
  show(Object.keys(drawn)[0]);
  const render = () => renderer.render(scene, camera);
  return { body, parts, solids: Object.keys(drawn), controls, show, trace, place, resize, render };
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
