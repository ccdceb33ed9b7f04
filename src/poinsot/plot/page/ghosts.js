"use strict";
// Other motions beside the own: the same solids, translucent, as long as each lasts.

const GHOST = { transparent: true, opacity: 0.28, depthWrite: false };

/**
 * Return what draws the ghosts at a time; nothing where there are none. `bodies` are those of the scene by the names
 * of their arrays, each with its solids by name, and of two bodies with `placed`, its place for the relative position.
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
