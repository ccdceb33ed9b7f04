"use strict";
// The stage of a scene: camera, light, stars, labels, size and resolution.

const SHARPEST = 2;
/** A software renderer takes as long for corners as for dots: few stars, of one triangle each. */
const STARS = 800;
/** Angle of the faintest star, radians. */
const STAR_SIZE = 0.0007;
/** Light of the Sun, of the camera and from all sides, with the Sun and without. */
const LIGHTS = { sun: [2.9, 0], camera: [0.6, 2.2], ambient: [0.9, 1.6] };
/** Pixels between labels, and the farthest that a label goes aside. */
const [GAP, FARTHEST_LABEL] = [2, 90];
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
  theme.paint(() => renderer.setClearColor(theme.sky));
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
  const [sun, lamp] = [0, 1].map(() => new THREE.DirectionalLight("#ffffff", 1));
  const ambient = new THREE.AmbientLight("#ffffff", 1);
  lamp.position.set(-1.5, 1.5, 3);
  camera.add(lamp);
  world.add(sun);
  scene.add(ambient, camera, world);
  const stars = starsOf();
  theme.paint(() => (stars.visible = theme.isSpace));
  scene.add(stars);

  /** Light the scene from a direction in the world; without one, from the camera. */
  function lightFrom(direction) {
    const k = direction ? 0 : 1;
    [sun.intensity, lamp.intensity, ambient.intensity] = [LIGHTS.sun[k], LIGHTS.camera[k], LIGHTS.ambient[k]];
    if (direction) sun.position.set(...direction).multiplyScalar(1e6);
  }
  lightFrom(null);

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

  function isDrawn(part) {
    for (let each = part; each; each = each.parent) if (!each.visible) return false;
    return part.isShown && part.layers.test(camera.layers);
  }

  /** Put the labels at their places; a label goes aside for an earlier one, and is hidden where it would go too far. */
  function placeLabels() {
    scene.updateMatrixWorld();
    const { clientWidth: width, clientHeight: height } = canvas;
    const taken = [];
    for (const label of labels) {
      const { x, y, z } = point.setFromMatrixPosition(label.matrixWorld).project(camera);
      label.size ??= [label.element.offsetWidth, label.element.offsetHeight];
      const [across, tall] = label.size;
      const [from, middle] = [((x + 1) / 2) * width - across / 2, ((1 - y) / 2) * height];
      let left = from;
      for (const each of taken.filter((one) => Math.abs(one.middle - middle) < (one.tall + tall) / 2)) {
        if (left < each.right + GAP && left + across + GAP > each.left) left = each.right + GAP;
      }
      const inside = left >= 0 && left + across <= width && middle >= tall / 2 && middle <= height - tall / 2;
      label.placed = isDrawn(label) && z < 1 && inside && left - from < FARTHEST_LABEL;
      label.element.hidden = !label.placed;
      if (!label.placed) continue;
      label.element.style.transform = `translate(${left.toFixed(1)}px, ${(middle - tall / 2).toFixed(1)}px)`;
      [label.left, label.middle] = [left, middle];
      taken.push({ left, right: left + across, middle, tall });
      taken.sort((one, other) => one.left - other.left);
    }
  }

  function render() {
    stars.position.copy(camera.position);
    stars.quaternion.copy(world.quaternion);
    stars.scale.setScalar(0.9 * camera.far);
    placeLabels();
    renderer.render(scene, camera);
  }

  const print = document.createElement("canvas");

  /** Draw with a fraction of the dots and with the labels, and use the picture. */
  function picture(part, take) {
    sharpen(part);
    render();
    [print.width, print.height] = [canvas.width, canvas.height];
    const pen = print.getContext("2d");
    pen.drawImage(canvas, 0, 0);
    const ratio = canvas.width / canvas.clientWidth;
    pen.scale(ratio, ratio);
    pen.textBaseline = "middle";
    for (const label of labels.filter((each) => each.placed)) {
      pen.font = getComputedStyle(label.element).font;
      [pen.strokeStyle, pen.lineWidth, pen.fillStyle] = [theme.sky, 3, label.colour];
      pen.strokeText(label.words, label.left, label.middle);
      pen.fillText(label.words, label.left, label.middle);
    }
    take(print);
  }

  const own = { scene, world, camera, controls, turn, resize, sharpen, render, picture, lightFrom, labels, setSky: theme.setSky };
  return Object.defineProperty(own, "sharpness", { get: () => sharpness });
}

/** Stars on a sphere around the camera: the same ones on every page, not those of the sky. */
function starsOf() {
  let seed = 1;
  const draw = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  const [places, colours] = [[], []];
  for (let i = 0; i < STARS; i++) {
    const [z, angle, faint] = [2 * draw() - 1, 2 * Math.PI * draw(), draw()];
    const across = Math.sqrt(1 - z * z);
    const centre = [across * Math.cos(angle), across * Math.sin(angle), z];
    const east = unit(cross([0, 0, 1], centre));
    const north = cross(centre, east);
    const size = STAR_SIZE * (1 + 1.6 * (1 - faint) ** 6);
    const light = 0.25 + 0.75 * (1 - faint) ** 3;
    for (const [a, b] of [[1.2, -0.7], [0, 1.4], [-1.2, -0.7]]) {
      places.push(...[0, 1, 2].map((k) => centre[k] + size * (a * east[k] + b * north[k])));
      colours.push(light, light, light * (0.9 + 0.2 * draw()));
    }
  }
  const geometry = new THREE.BufferGeometry()
    .setAttribute("position", new THREE.BufferAttribute(Float32Array.from(places), 3))
    .setAttribute("color", new THREE.BufferAttribute(Float32Array.from(colours), 3));
  const look = { vertexColors: true, side: THREE.DoubleSide, depthWrite: false };
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(look));
}
