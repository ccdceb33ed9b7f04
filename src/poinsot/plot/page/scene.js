"use strict";
// Elements of scenes in three dimensions: solids, axes, vectors and the paths of their tips.

const SPACE_AXIS = 1.75;
const LONGEST_MOMENTUM = 1.9;
const LIGHT = "#D3E0EA";
const SHADE = "#9DB6C9";
const UP = new THREE.Vector3(0, 1, 0);
/** Radii of shafts: at one place thinner shafts are inside thicker ones. */
const SHAFT = { space_axes: 0.007, orbit_frame: 0.009, body_axes: 0.011, sun: 0.0125, observer: 0.0135, momentum: 0.0145, vector: 0.017, omega: 0.0205 };

/** A wide line along a path, drawn through the last points before a tip. */
class Tail {
  constructor(parent, colour, width, path, most) {
    const count = path.length / 3 - 1;
    const [corners, starts, ends] = [0, 1, 2].map(() => new Float32Array(12 * count));
    const index = new Uint32Array(6 * count);
    for (let i = 0; i < count; i++) {
      for (let corner = 0; corner < 4; corner++) {
        [corners[12 * i + 3 * corner], corners[12 * i + 3 * corner + 1]] = [corner & 1 ? 1 : -1, corner >> 1];
      }
      index.set([2, 0, 3, 0, 1, 3].map((corner) => 4 * i + corner), 6 * i);
    }
    // Not the instances of LineSegmentsGeometry, each of which costs a software renderer as much as a mesh.
    this.geometry = new THREE.BufferGeometry()
      .setAttribute("position", new THREE.BufferAttribute(corners, 3))
      .setAttribute("instanceStart", new THREE.BufferAttribute(starts, 3))
      .setAttribute("instanceEnd", new THREE.BufferAttribute(ends, 3))
      .setIndex(new THREE.BufferAttribute(index, 1));
    [this.most, this.cut] = [most, 0];
    this.follow(path);
    this.line = new THREE.LineSegments2(
      this.geometry,
      painted(new THREE.LineMaterial({ linewidth: width, polygonOffset: true, polygonOffsetFactor: -2 }), colour),
    );
    this.line.frustumCulled = false;
    this.line.layers.mask = parent.layers.mask;
    parent.add(this.line);
  }

  /** Go through other points, of the same number. */
  follow(path) {
    const { instanceStart, instanceEnd } = this.geometry.attributes;
    [this.path, this.ends] = [path, instanceEnd];
    for (let at = 0, i = 0; at < instanceEnd.array.length; at += 12, i += 3) {
      for (let corner = 0; corner < 12; corner += 3) {
        instanceStart.array.set(path.subarray(i, i + 3), at + corner);
        instanceEnd.array.set(path.subarray(i + 3, i + 6), at + corner);
      }
    }
    instanceStart.needsUpdate = instanceEnd.needsUpdate = true;
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

/** An arrow from the origin with a given tip; an arrow too short for a head is hidden. */
class Arrow {
  constructor(parent, colour, width, label) {
    const material = painted(new THREE.MeshBasicMaterial(), colour);
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(width, width, 1, 12), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(3.2 * width, 9 * width, 20), material);
    this.head_length = 9 * width;
    this.gap = Math.min(0.12, 15 * width);
    this.direction = new THREE.Vector3();
    this.label = new Label(label, colour);
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
    this.label.position.y = length + this.gap;
  }
}

/** A material whose colour depends on the background. */
function painted(material, colour) {
  theme.paint(() => material.color.set(theme.inScene(colour)));
  return material;
}

/** Labels of the scene, in the order in which they keep their places. */
const labels = [];

/** A place in the scene with a word next to it, which is an element over the canvas. */
class Label extends THREE.Group {
  constructor(words, colour) {
    super();
    this.isLabel = true;
    this.words = words;
    this.isShown = true;
    this.element = document.createElement("span");
    this.element.textContent = words;
    document.getElementById("labels").append(this.element);
    theme.paint(() => (this.element.style.color = this.colour = theme.inScene(colour)));
    labels.push(this);
  }
}

/** The points of the tip of a vector, at the times for curves. */
function path(point) {
  const out = new Float32Array(3 * motion.fine.length);
  motion.fine.forEach((t, i) => out.set(point(t), 3 * i));
  return out;
}

/** A thin line through points. */
function whole(points, colour, opacity) {
  const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3));
  return new THREE.Line(geometry, painted(new THREE.LineBasicMaterial({ transparent: true, opacity }), colour));
}

function axes(parent, letters, length, colour, width) {
  const group = new THREE.Group();
  for (let k = 0; k < 3; k++) {
    const arrow = new Arrow(group, colour, width, letters[k]);
    arrow.point([0, 1, 2].map((i) => (i === k ? length : 0)));
  }
  parent.add(group);
  return group;
}

/** A sphere, smooth to a dot; a software renderer takes as long for its corners as for its dots. */
const sphere = () => new THREE.SphereGeometry(1, 48, 28);

/** A solid whose octants alternate between two shades, so that its rotation is visible. */
function shaded(geometry, light = LIGHT, shade = SHADE) {
  const [bright, dark] = [light, shade].map((colour) => new THREE.Color(colour));
  const flat = geometry.index ? geometry.toNonIndexed() : geometry;
  const place = flat.attributes.position;
  const colours = new Float32Array(3 * place.count);
  for (let i = 0; i < place.count; i += 3) {
    const middle = [0, 1, 2].map((k) => place.array[3 * i + k] + place.array[3 * i + 3 + k] + place.array[3 * i + 6 + k]);
    const colour = middle[0] * middle[1] * middle[2] > 0 ? bright : dark;
    for (let k = 0; k < 3; k++) colour.toArray(colours, 3 * (i + k));
  }
  flat.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  return new THREE.Mesh(flat, new THREE.MeshLambertMaterial({ vertexColors: true }));
}

/** A translucent solid of given half sides along the principal axes. */
function along(principal, geometry, sides) {
  const solid = shaded(geometry);
  solid.quaternion.copy(quaternion(principal));
  solid.scale.set(...sides);
  Object.assign(solid.material, { transparent: true, opacity: 0.9 });
  return solid;
}

function quaternion([w, x, y, z]) {
  return new THREE.Quaternion(x, y, z, w);
}

/** A part of the shape of the body. */
function part({ triangles, spheres, solid, sides, place, turn }) {
  if (triangles) return mesh(motion.unscaled(triangles));
  if (spheres) return beads(motion.unscaled(spheres));
  const round = solid === "ellipsoid" ? sphere() : new THREE.CylinderGeometry(1, 1, 2, 64, 2);
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
