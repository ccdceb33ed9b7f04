"use strict";
// From where one body is seen: with the space axes, the body, its orbit or the attractor at rest.

/** Of the distance of the eye from the attractor: the size of the body that is seen from there. */
const SEEN = 0.035;

function viewsOf(motion, stage, around) {
  const { world, camera, controls } = stage;
  const { far } = around;
  const orbit = motion.page.around.orbit;
  const names = { space: "space axes", body: "the body" };
  if (orbit?.moves) names.orbit = "the orbit";
  if (orbit) names.attractor = orbit.attractor;
  const reach = far?.reach ?? 0;
  camera.far = Math.max(100, 8 * reach);
  controls.maxDistance = Math.max(30, 5 * reach);
  const eyes = { attractor: FROM.clone().multiplyScalar(0.6 * reach) };
  let name = names.orbit ? "orbit" : "space";

  function look(wanted) {
    eyes[name] = camera.position.clone();
    name = wanted;
    camera.position.copy(eyes[name] ?? FROM);
    controls.update();
  }

  const turns = {
    space: () => world.quaternion.identity(),
    attractor: () => world.quaternion.identity(),
    body: (_, q) => world.quaternion.copy(quaternion(conjugate(q))),
    orbit: (t) => {
      const [radial, transverse, normal] = axesOfOrbit(t);
      world.quaternion.copy(quaternion(conjugate(attitudeOf([transverse, normal, radial]))));
    },
  };

  function place(t, q, near) {
    turns[name](t, q);
    const away = name === "attractor";
    world.position.set(0, 0, 0);
    if (far) far.name.visible = away;
    if (away) world.position.copy(far.group.position).negate();
    near.scale.setScalar(away ? Math.max(1, SEEN * camera.position.length()) : 1);
    near.traverse((part) => part.isSprite && (part.visible = !away));
  }

  return { names, usual: name, look, place };
}
