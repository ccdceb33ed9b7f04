"use strict";
// Views of the scene, in which the space axes, a body, the orbit, the line of sight or the attractor are at rest.

/** Size of a body seen from the attractor, as fraction of the distance of the eye from the attractor. */
const SEEN = 0.035;
/** Size of the attractor, as fraction of this distance. */
const DOT = 0.006;

/**
 * Return the views of a scene and of its surroundings. A view has its label and an object at rest: `turn` returns the
 * attitude of this object at a time, `centre` its place in the world after it is drawn.
 */
function viewsOf(motion, { world, camera, controls }, { near, far, own, usual }) {
  const all = { ...own };
  const orbit = motion.page.around.orbit;
  if (orbit?.moves) all.orbit = { words: "the orbit", turn: upwardsOfOrbit };
  if (motion.page.around.arrows.includes("observer")) all.observer = { words: "the line of sight, s₃ upwards", turn: towardsObserver };
  if (orbit) all.attractor = { words: orbit.attractor, centre: () => far.group.position };
  const reach = far?.reach ?? 0;
  camera.far = Math.max(100, 8 * reach);
  controls.maxDistance = Math.max(30, 5 * reach);
  const eyes = { attractor: FROM.clone().multiplyScalar(0.6 * reach), observer: new THREE.Vector3(FROM.length(), 0, 0) };
  let name = usual;

  function look(wanted) {
    eyes[name] = camera.position.clone();
    name = wanted;
    camera.position.copy(eyes[name] ?? FROM);
    controls.update();
  }

  function place(t) {
    const { turn, centre } = all[name];
    const away = name === "attractor";
    world.quaternion.copy(quaternion(turn ? conjugate(turn(t)) : [1, 0, 0, 0]));
    world.position.set(0, 0, 0);
    if (centre) world.position.copy(centre()).negate();
    if (far) {
      far.name.visible = away;
      far.ball.scale.setScalar(away ? Math.max(1, (DOT * camera.position.length()) / far.size) : 1);
    }
    near.scale.setScalar(away ? Math.max(1, SEEN * camera.position.length()) : 1);
    near.traverse((part) => part.isLabel && (part.isShown = !away));
  }

  const names = Object.fromEntries(Object.entries(all).map(([key, { words }]) => [key, words]));
  return { names, usual, look, place };
}

/** The attitude of axes towards the observer, to the right of the observer and upwards. */
function towardsObserver(t) {
  const near = unit(motion.vector("observer", t));
  const right = unit(cross([0, 0, 1], near));
  return attitudeOf([near, right, cross(near, right)]);
}

/** The attitude of an orbit with its radial axis upwards and the transverse axis to the right. */
function upwardsOfOrbit(t) {
  const [radial, transverse, normal] = axesOfOrbit(t);
  return attitudeOf([transverse, normal, radial]);
}
