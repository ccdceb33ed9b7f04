"use strict";
// Saved pictures of the scene, and animations of the motion from the present time on, at the chosen speed.

const FILM = { perSecond: 20, longest: 10, widest: 640, bitsPerSecond: 4e6, coarsest: 0.4 };
/** Seconds of an animation that determine its colours. */
const SAMPLED = [0, 0.25, 0.5, 0.75, 1];
const VIDEOS = { mp4: "video/mp4;codecs=avc1.42E01F", webm: "video/webm" };
const VIDEO = Object.keys(VIDEOS).find((kind) => window.MediaRecorder?.isTypeSupported(VIDEOS[kind]));

/** Offer bytes as a file with the name of the motion. */
function offer(file, ending) {
  const link = document.createElement("a");
  [link.href, link.download] = [URL.createObjectURL(file), `${document.title.split(":")[0] || "motion"}.${ending}`];
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Return the frames of an animation: their number, their canvas, and `draw`, which draws the frame at a second. */
function framesOf(scene) {
  const last = motion.times[motion.times.length - 1];
  const first = clock.time < last ? clock.time : motion.times[0];
  const seconds = Math.min((last - first) / clock.rate, FILM.longest);
  const canvas = document.createElement("canvas");
  const { clientWidth, clientHeight } = scene.controls.domElement;
  const scale = Math.min(1, FILM.widest / clientWidth);
  [canvas.width, canvas.height] = [clientWidth, clientHeight].map((side) => 2 * Math.round((scale * side) / 2));
  const pen = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
  [pen.font, pen.imageSmoothingQuality] = ["13px system-ui, sans-serif", "high"];

  function draw(second, part = 1) {
    const t = Math.min(first + second * clock.rate, last);
    scene.place(t);
    scene.picture(part, (picture) => pen.drawImage(picture, 0, 0, canvas.width, canvas.height));
    pen.fillStyle = theme.ink;
    pen.fillText(clock.inWords(t), 8, canvas.height - 10);
    return pen.getImageData(0, 0, canvas.width, canvas.height).data; // waits until all is drawn
  }

  return { canvas, seconds, count: Math.max(2, Math.round(seconds * FILM.perSecond)), draw };
}

const pause = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));

/** An animation of equal intervals, drawn frame by frame; `goes` receives its progress and returns false to end it. */
async function gifFilm({ canvas, seconds, count, draw }, goes) {
  const film = new Gif(canvas.width, canvas.height, paletteOf(SAMPLED.map((part) => draw(part * seconds))));
  for (let i = 0; i < count && goes(i / count); i++) {
    film.add(draw(i / FILM.perSecond), 100 / FILM.perSecond);
    await pause(0);
  }
  return film.file();
}

/** An animation that the browser records while it plays, with fewer dots if frames are slow. */
async function recordedFilm({ canvas, seconds, draw }, goes) {
  let part = 1;
  const stream = canvas.captureStream(FILM.perSecond);
  const recorder = new MediaRecorder(stream, { mimeType: VIDEOS[VIDEO], videoBitsPerSecond: FILM.bitsPerSecond });
  const [pieces, ended] = [[], new Promise((done) => (recorder.onstop = done))];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  recorder.start();
  const start = performance.now();
  const passed = () => (performance.now() - start) / 1000;
  while (passed() < seconds && goes(passed() / seconds)) {
    const before = passed();
    draw(before, part);
    if (passed() - before > 0.5 / FILM.perSecond) part = Math.max(0.8 * part, FILM.coarsest);
    await pause(Math.max(0, 1000 * (before + 1 / FILM.perSecond - passed())));
  }
  draw(Math.min(passed(), seconds), part);
  await pause(2000 / FILM.perSecond); // until the browser has recorded the last frame
  recorder.stop();
  await ended;
  return new Blob(pieces, { type: VIDEOS[VIDEO] });
}

/** Connect the buttons. During the recording of an animation its button shows the progress and ends it. */
function connectSaving(scene, changed) {
  const [picture, gif, video] = ["save", "gif", "video"].map((id) => document.getElementById(id));
  picture.addEventListener("click", () =>
    scene.picture(1, (canvas) => canvas.toBlob((file) => offer(file, "png"), "image/png")),
  );
  let goes = false;

  function connect(button, ending, film) {
    const name = `Save ${ending.toUpperCase()}`;
    button.textContent = name;
    button.addEventListener("click", async () => {
      if (goes) return (goes = false);
      goes = true;
      clock.setPlaying(false);
      for (const each of [gif, video]) each.disabled = each !== button;
      const told = (part) => {
        button.textContent = `End ${ending.toUpperCase()}, ${Math.round(100 * part)} %`;
        return goes;
      };
      offer(await film(framesOf(scene), told), ending);
      for (const each of [gif, video]) each.disabled = false;
      button.textContent = name;
      goes = false;
      scene.sharpen(1);
      changed();
    });
  }

  connect(gif, "gif", gifFilm);
  if (VIDEO) connect(video, VIDEO, recordedFilm);
  else video.remove();
}
