"use strict";
// Other motions: translucent copies of the solids, for the duration of each motion.

const GHOST = { transparent: true, opacity: 0.28, depthWrite: false };

/**
 * Return a function that draws the other motions at a time; nothing without them. `bodies` are the bodies of the
 * scene by the names of their arrays, each with its solids by name, and for two bodies with `placed`, its place for a
 * relative position.
 */
function ghostsOf(ghosts, bodies) {
  if (!ghosts.length) return null;
  const group = new THREE.Group();
  const all = ghosts.flatMap((ghost) => {
    const other = motionOf(motion.timesOf(ghost.times), ghost.arrays);
    return Object.entries(bodies).map(([name, { drawn, placed }]) => {
      const body = new THREE.Group();
      group.add(body);
      const solids = Object.fromEntries(Object.entries(drawn).map(([key, solid]) => [key, ghostly(solid)]));
      body.add(...Object.values(solids));
      return { body, solids, drawn, placed, name, other };
    });
  });

  function place(t) {
    for (const { body, solids, drawn, placed, name, other } of all) {
      body.visible = other.times[0] <= t && t <= other.times[other.times.length - 1];
      if (!body.visible) continue;
      body.quaternion.copy(quaternion(other.quaternion(t, name)));
      if (placed) body.position.set(...placed(other.position(t)));
      for (const [key, solid] of Object.entries(solids)) {
        solid.visible = drawn[key].visible;
        solid.scale.copy(drawn[key].scale);
      }
    }
  }

  return { group, bodies: all.map(({ body }) => body), place };
}

/** A translucent copy of a solid. */
function ghostly(solid) {
  const copy = solid.clone();
  copy.traverse((part) => part.material && (part.material = Object.assign(part.material.clone(), GHOST)));
  return copy;
}
