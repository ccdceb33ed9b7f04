"use strict";
// The scene in three dimensions: the body of unit size, axes, vectors and the paths of their tips.

const BODY_AXIS = 1.35;
const SPACE_AXIS = 1.75;
const LONGEST_OMEGA = 1.55;
const LONGEST_MOMENTUM = 1.95;
const TAIL_TURNS = 10;
const LIGHT = "#D3E0EA";
const SHADE = "#9DB6C9";
const UP = new THREE.Vector3(0, 1, 0);
const SHARPEST = 2;

/** A fat line along a path, of which the last points before a tip are drawn. */
class Tail {
  constructor(parent, colour, width, path, most) {
    const count = path.length / 3 - 1;
    const [corners, starts, ends] = [0, 1, 2].map(() => new Float32Array(12 * count));
    const index = new Uint32Array(6 * count);
    for (let i = 0; i < count; i++) {
      for (let corner = 0; corner < 4; corner++) {
        const at = 12 * i + 3 * corner;
        [corners[at], corners[at + 1]] = [corner & 1 ? 1 : -1, corner >> 1];
        starts.set(path.subarray(3 * i, 3 * i + 3), at);
        ends.set(path.subarray(3 * i + 3, 3 * i + 6), at);
      }
      index.set([2, 0, 3, 0, 1, 3].map((corner) => 4 * i + corner), 6 * i);
    }
    // Not the instances of LineSegmentsGeometry, each of which costs a software renderer as much as a mesh.
    this.geometry = new THREE.BufferGeometry()
      .setAttribute("position", new THREE.BufferAttribute(corners, 3))
      .setAttribute("instanceStart", new THREE.BufferAttribute(starts, 3))
      .setAttribute("instanceEnd", new THREE.BufferAttribute(ends, 3))
      .setIndex(new THREE.BufferAttribute(index, 1));
    [this.path, this.ends, this.most, this.cut] = [path, this.geometry.attributes.instanceEnd, most, 0];
    this.line = new THREE.LineSegments2(
      this.geometry,
      new THREE.LineMaterial({ color: colour, linewidth: width, polygonOffset: true, polygonOffsetFactor: -2 }),
    );
    this.line.frustumCulled = false;
    this.line.layers.mask = parent.layers.mask;
    parent.add(this.line);
  }

  /** End a piece of the line at a point. */
  end(piece, x, y, z) {
    for (let at = 12 * piece; at < 12 * piece + 12; at += 3) {
      this.ends.array[at] = x;
      this.ends.array[at + 1] = y;
      this.ends.array[at + 2] = z;
    }
    this.ends.addUpdateRange(12 * piece, 12);
  }

  /** Draw the points first..last of the path, then the tip. */
  draw(first, last, tip) {
    const from = Math.max(first, last - this.most + 1);
    this.ends.clearUpdateRanges();
    const next = 3 * this.cut + 3;
    this.end(this.cut, this.path[next], this.path[next + 1], this.path[next + 2]);
    this.end(last, tip[0], tip[1], tip[2]);
    this.cut = last;
    this.ends.needsUpdate = true;
    this.geometry.setDrawRange(6 * from, 6 * (last - from + 1));
  }
}

/** An arrow from the origin whose length is set with its tip; too short to have a head, it is hidden. */
class Arrow {
  constructor(parent, colour, width, label) {
    const material = new THREE.MeshBasicMaterial({ color: colour });
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(width, width, 1, 12), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(3.2 * width, 9 * width, 20), material);
    this.head_length = 9 * width;
    this.direction = new THREE.Vector3();
    this.label = text(label, colour);
    this.group = new THREE.Group().add(this.shaft, this.head, this.label);
    parent.add(this.group);
  }

  point(tip, factor = 1) {
    this.direction.fromArray(tip);
    const length = this.direction.length() * factor;
    this.group.visible = length > 1e-6;
    if (!this.group.visible) return;
    const head = Math.min(this.head_length, length / 2);
    this.group.quaternion.setFromUnitVectors(UP, this.direction.normalize());
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

function quaternion([w, x, y, z]) {
  return new THREE.Quaternion(x, y, z, w);
}

/** A part of the shape of the body. */
function part({ triangles, spheres, solid, sides, place, turn }) {
  if (triangles) return mesh(motion.unscaled(triangles));
  if (spheres) return beads(motion.unscaled(spheres));
  const round = solid === "ellipsoid" ? new THREE.SphereGeometry(1, 64, 48) : new THREE.CylinderGeometry(1, 1, 2, 64, 2);
  const drawn = shaded(solid === "ellipsoid" ? round : round.rotateX(Math.PI / 2));
  drawn.scale.set(...sides);
  drawn.position.set(...place);
  drawn.quaternion.copy(quaternion(turn));
  return drawn;
}

/** Spheres as one solid; rows are centre and radius. */
function beads(rows) {
  const count = rows.length / 4;
  const one = new THREE.SphereGeometry(1, ...(count > 500 ? [8, 6] : [24, 16])).toNonIndexed();
  const [corners, normals] = ["position", "normal"].map((name) => one.attributes[name].array);
  const all = { position: new Float32Array(count * corners.length), normal: new Float32Array(count * corners.length) };
  for (let i = 0; i < count; i++) {
    all.normal.set(normals, i * corners.length);
    for (let k = 0; k < corners.length; k++) {
      all.position[i * corners.length + k] = rows[4 * i + (k % 3)] + rows[4 * i + 3] * corners[k];
    }
  }
  const geometry = new THREE.BufferGeometry();
  for (const [name, values] of Object.entries(all)) geometry.setAttribute(name, new THREE.BufferAttribute(values, 3));
  return shaded(geometry);
}

/** Triangles, three vertices each, with sharp edges. */
function mesh(corners) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(corners), 3));
  geometry.computeVertexNormals();
  return shaded(geometry);
}

/** Whether the processor draws, to which smoothed edges cost more than more dots. */
function drawsWithoutGraphics() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const named = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** Return the scene; it draws itself at a time. */
function sceneOf(motion, canvas) {
  const { page, fine } = motion;
  const { solids, colours } = page;
  const software = drawsWithoutGraphics();
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: !software, alpha: false });
  renderer.setClearColor("#ffffff");
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
  const principal = quaternion(solids.principal);
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
    traced = k;
    traces[k] ??= new Tail(parts.trace, colours.body_axes, 2, path((t) => axisTip(k, t)), most);
    traces.forEach((tail, i) => tail && (tail.line.visible = i === k));
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

  /** Draw with a part of the dots that the screen has, or without a graphics card with more when at rest. */
  function sharpen(part) {
    const dots = Math.min(window.devicePixelRatio, SHARPEST);
    renderer.setPixelRatio(part === 1 && software ? SHARPEST : dots * part);
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.zoom = Math.min(1, camera.aspect * 0.97);
    camera.updateProjectionMatrix();
    const label = 36 / height / camera.zoom;
    scene.traverse((part) => part.isSprite && part.scale.set(2 * label * 0.57, label * 0.57, 1));
  }

  /** Turn the view by angles about the vertical and about the horizontal across the line of sight, and zoom. */
  function turn(around, over, zoom) {
    const across = new THREE.Vector3().crossVectors(camera.up, camera.position).normalize();
    const steepness = Math.acos(camera.position.z / camera.position.length());
    const least = 0.05;
    camera.position.applyAxisAngle(across, Math.min(Math.max(steepness + over, least), Math.PI - least) - steepness);
    camera.position.applyAxisAngle(camera.up, around).multiplyScalar(zoom);
    controls.update();
  }

  trace(traced);
  show(Object.keys(drawn)[0]);
  const render = () => renderer.render(scene, camera);
  return { body, drawn, parts, paths, tails, traces, solids: Object.keys(drawn), controls, show, trace, turn, place, resize, sharpen, render };
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
