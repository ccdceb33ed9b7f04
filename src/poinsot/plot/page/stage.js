"use strict";
// The stage of a scene: camera, light, size and resolution.

const SHARPEST = 2;
/** Height of a letter as fraction of the height of the picture of a word. */
const LETTER = 0.7;
const FROM = new THREE.Vector3(3.7, -6.2, 2.9);

/** True if the processor draws, for which smoothed edges cost more than more dots. */
function drawsWithoutGraphics() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const named = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/**
 * Return an empty scene with a camera; `render` draws it. All objects are in the world, which a view turns and moves
 * under the camera, so that a body or an orbit is fixed in the picture.
 */
function stageOf(canvas) {
  const software = drawsWithoutGraphics();
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: !software, alpha: false });
  theme.paint(() => renderer.setClearColor(theme.ground));
  const scene = new THREE.Scene();
  const world = new THREE.Group();
  const camera = new THREE.PerspectiveCamera(32, 1, 0.1, 100);
  camera.up.set(0, 0, 1);
  camera.position.copy(FROM);
  const controls = new THREE.OrbitControls(camera, canvas);
  canvas.style.touchAction = "pan-y"; // one finger scrolls the page up and down, two turn the view and zoom
  controls.enablePan = false;
  controls.touches.TWO = 3; // THREE.TOUCH.DOLLY_ROTATE
  [controls.minDistance, controls.maxDistance] = [2, 30];
  const sun = new THREE.DirectionalLight("#ffffff", 2.2);
  sun.position.set(-1.5, 1.5, 3);
  camera.add(sun);
  scene.add(new THREE.AmbientLight("#ffffff", 1.6), camera, world);

  let sharpness = 1;

  /** Draw with a fraction of the dots of the screen; at rest, without a graphics card, with more. */
  function sharpen(part) {
    sharpness = part;
    const dots = Math.min(window.devicePixelRatio, SHARPEST);
    const ratio = part === 1 && software ? SHARPEST : dots * part;
    if (ratio !== renderer.getPixelRatio()) renderer.setPixelRatio(ratio); // allocates all dots anew
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas.parentElement;
    renderer.setSize(width, height);
    camera.aspect = width / height;
    camera.zoom = Math.min(1, camera.aspect * 0.97, (1 - 38 / height) * 1.07); // room for the labels
    camera.updateProjectionMatrix();
    const label = 36 / height / camera.zoom;
    scene.traverse((part) => part.isSprite && part.scale.set(part.userData.aspect * label * 0.57, label * 0.57, 1));
  }

  /** Turn the view by angles about the vertical and about the horizontal across the line of sight, and zoom. */
  function turn(around, over, zoom) {
    const from = camera.position.clone().sub(controls.target);
    const across = new THREE.Vector3().crossVectors(camera.up, from).normalize();
    const steepness = Math.acos(from.z / from.length());
    const least = 0.05;
    from.applyAxisAngle(across, Math.min(Math.max(steepness + over, least), Math.PI - least) - steepness);
    camera.position.copy(from.applyAxisAngle(camera.up, around).multiplyScalar(zoom).add(controls.target));
    controls.update();
  }

  const point = new THREE.Vector3();

  /** Move words to the right that would cover other words. */
  function spread() {
    scene.updateMatrixWorld();
    const [across, upwards] = [0, 5].map((k) => camera.projectionMatrix.elements[k]);
    const taken = [];
    scene.traverseVisible((word) => {
      if (!word.isSprite || !word.material.visible || !word.layers.test(camera.layers)) return;
      const { x: from, y } = point.setFromMatrixPosition(word.matrixWorld).project(camera);
      const [width, height] = [word.scale.x * across * word.userData.filled, word.scale.y * upwards * LETTER];
      const near = taken.filter((each) => Math.abs(each.y - y) < (each.height + height) / 2);
      near.sort((one, other) => one.x - other.x);
      let x = from;
      for (const each of near) {
        const apart = (each.width + width) / 2;
        if (Math.abs(each.x - x) < apart) x = each.x + apart;
      }
      taken.push({ x, y, width, height });
      word.center.x = 0.5 - (x - from) / (word.scale.x * across);
    });
  }

  function render() {
    spread();
    renderer.render(scene, camera);
  }

  /** Draw with a fraction of the dots, and use the picture before the browser discards it. */
  function picture(part, take) {
    sharpen(part);
    render();
    take(canvas);
  }

  const own = { scene, world, camera, controls, turn, resize, sharpen, render, picture };
  return Object.defineProperty(own, "sharpness", { get: () => sharpness });
}
