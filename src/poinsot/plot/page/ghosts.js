"use strict";
// Other motions of the body beside its own: the same solid, translucent, as long as each lasts.

const GHOST = { transparent: true, opacity: 0.28, depthWrite: false };

/** Return what draws the ghosts at a time; nothing where there are none. `drawn` are the solids of the body by name. */
function ghostsOf(ghosts, drawn) {
  if (!ghosts.length) return null;
  const group = new THREE.Group();
  const all = ghosts.map(({ times, quaternion: turns, omega_body: rates }) => {
    const body = new THREE.Group();
    group.add(body);
    const solids = Object.fromEntries(Object.entries(drawn).map(([name, solid]) => [name, ghostly(solid)]));
    body.add(...Object.values(solids));
    return { body, solids, times: motion.timesOf(times), turns: motion.unscaled(turns), rates: motion.unscaled(rates) };
  });

  function place(t) {
    for (const { body, solids, times, turns, rates } of all) {
      body.visible = times[0] <= t && t <= times[times.length - 1];
      if (!body.visible) continue;
      body.quaternion.copy(quaternion(motion.attitude(turns, rates, t, times)));
      for (const [name, solid] of Object.entries(solids)) {
        solid.visible = drawn[name].visible;
        solid.scale.copy(drawn[name].scale);
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
