"use strict";
// Facets of the body, coloured by their optical properties, and wheels.

const MIRROR = "#7FB4E6";
const WHITE = "#F2F0EA";
const DARK = "#3D5290";
const WHEEL = { radius: 0.1, thickness: 0.045, from: 0.36, light: "#AEB7C0", shade: "#4A545E" };

/** Facets as squares, the darker the more light they absorb, the bluer the more they mirror. */
function facets({ corners, shares }) {
  const at = motion.unscaled(corners);
  const [points, colours] = [[], []];
  const [mirror, white, dark] = [MIRROR, WHITE, DARK].map((colour) => new THREE.Color(colour));
  shares.forEach(([specular, diffuse], i) => {
    const colour = new THREE.Color(0, 0, 0);
    for (const [each, part] of [[mirror, specular], [white, diffuse], [dark, 1 - specular - diffuse]]) {
      colour.add(each.clone().multiplyScalar(part));
    }
    for (const corner of [0, 1, 2, 0, 2, 3]) {
      points.push(...at.slice(12 * i + 3 * corner, 12 * i + 3 * corner + 3));
      colours.push(colour.r, colour.g, colour.b);
    }
  });
  const geometry = new THREE.BufferGeometry()
    .setAttribute("position", new THREE.BufferAttribute(Float32Array.from(points), 3))
    .setAttribute("color", new THREE.BufferAttribute(Float32Array.from(colours), 3));
  geometry.computeVertexNormals();
  return new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ vertexColors: true }));
}

/** Return a function that draws wheels on their axes, at some distance from the centre; nothing without wheels. */
function wheelsOf(motion) {
  const { wheels } = motion.page.around;
  if (!wheels) return null;
  const group = new THREE.Group();
  const { radius, thickness, from, light, shade } = WHEEL;
  const all = wheels.axes.map((axis) => {
    const wheel = shaded(new THREE.CylinderGeometry(radius, radius, thickness, 32, 2), light, shade);
    wheel.position.set(...axis).multiplyScalar(from);
    group.add(wheel);
    return { wheel, upright: new THREE.Quaternion().setFromUnitVectors(UP, new THREE.Vector3(...axis)) };
  });

  function place(t) {
    const angles = motion.vector("wheel_angles", t);
    all.forEach(({ wheel, upright }, i) => wheel.quaternion.setFromAxisAngle(UP, angles[i]).premultiply(upright));
  }

  return { group, place };
}
