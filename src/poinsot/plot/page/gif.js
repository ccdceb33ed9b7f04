"use strict";
// Animation as GIF 89a: one palette by median cut, and the changed part of each frame. Pictures are bytes r, g, b, a.

const TRANSPARENT = 255;
/** Number of bits of each component that distinguish colours. */
const CELLS = 1 << 15;
const cell = (picture, i) => ((picture[i] >> 3) << 10) | ((picture[i + 1] >> 3) << 5) | (picture[i + 2] >> 3);
const parted = (at) => [at >> 10, (at >> 5) & 31, at & 31];

/** The 255 colours of pictures: boxes of cells. The longest and fullest box is cut in two repeatedly. */
function paletteOf(pictures) {
  const [counts, sums] = [new Float64Array(CELLS), new Float64Array(3 * CELLS)];
  for (const picture of pictures) {
    for (let i = 0; i < picture.length; i += 4) {
      const at = cell(picture, i);
      counts[at] += 1;
      for (let k = 0; k < 3; k++) sums[3 * at + k] += picture[i + k];
    }
  }
  const total = (cells) => cells.reduce((sum, at) => sum + counts[at], 0);

  function box(cells) {
    const lengths = [0, 1, 2].map((k) => {
      const along = cells.map((at) => parted(at)[k]);
      return along.reduce((a, b) => Math.max(a, b)) - along.reduce((a, b) => Math.min(a, b));
    });
    const longest = Math.max(...lengths);
    return { cells, axis: lengths.indexOf(longest), size: longest * Math.sqrt(total(cells)) };
  }

  function cut({ cells, axis }) {
    cells.sort((a, b) => parted(a)[axis] - parted(b)[axis]);
    const half = total(cells) / 2;
    let [i, sum] = [0, counts[cells[0]]];
    while (i < cells.length - 2 && sum + counts[cells[i + 1]] / 2 < half) sum += counts[cells[++i]];
    return [box(cells.slice(0, i + 1)), box(cells.slice(i + 1))];
  }

  const boxes = [box(Array.from(counts.keys()).filter((at) => counts[at]))];
  while (boxes.length < TRANSPARENT) {
    boxes.sort((a, b) => a.size - b.size);
    if (!boxes[boxes.length - 1].size) break;
    boxes.push(...cut(boxes.pop()));
  }
  return boxes.map(({ cells }) =>
    [0, 1, 2].map((k) => Math.round(cells.reduce((sum, at) => sum + sums[3 * at + k], 0) / total(cells))),
  );
}

/** A GIF file; `add` appends frames. */
class Gif {
  constructor(width, height, palette) {
    [this.width, this.height, this.palette] = [width, height, palette];
    this.nearest = new Int16Array(CELLS).fill(-1);
    this.bytes = [...Array.from("GIF89a", (letter) => letter.charCodeAt(0)), ...this.two(width), ...this.two(height), 0xf7, 0, 0];
    for (let i = 0; i < 256; i++) this.bytes.push(...(palette[i] ?? [0, 0, 0]));
    this.bytes.push(0x21, 0xff, 11, ...Array.from("NETSCAPE2.0", (letter) => letter.charCodeAt(0)), 3, 1, 0, 0, 0);
    this.before = null;
  }

  two(number) {
    return [number & 255, number >> 8];
  }

  /** Add a picture with its duration in hundredths of a second. */
  add(picture, hundredths) {
    const colours = new Uint8Array(this.width * this.height);
    for (let i = 0; i < colours.length; i++) colours[i] = this.colour(cell(picture, 4 * i));
    const shown = this.before ? colours.map((colour, i) => (colour === this.before[i] ? TRANSPARENT : colour)) : colours;
    this.bytes.push(0x21, 0xf9, 4, 5, ...this.two(hundredths), TRANSPARENT, 0);
    this.bytes.push(0x2c, 0, 0, 0, 0, ...this.two(this.width), ...this.two(this.height), 0);
    this.compress(shown);
    this.before = colours;
  }

  /** The number of the colour in the palette that is nearest to a cell. */
  colour(at) {
    if (this.nearest[at] < 0) {
      const wanted = parted(at).map((x) => 8 * x + 4);
      const away = this.palette.map((colour) => norm(mix(colour, wanted, 1, -1)));
      this.nearest[at] = away.indexOf(Math.min(...away));
    }
    return this.nearest[at];
  }

  /** Write numbers of colours by the algorithm of Lempel, Ziv and Welch, in blocks of 255 bytes. */
  compress(colours) {
    const [CLEAR, END, MOST] = [256, 257, 4096];
    const children = new Int16Array(256 * MOST).fill(-1);
    const block = [];
    let [next, width, held, bits] = [END + 1, 9, 0, 0];

    const flush = () => this.bytes.push(block.length, ...block.splice(0));
    function write(code) {
      held |= code << bits;
      bits += width;
      while (bits >= 8) byte();
    }
    function byte() {
      block.push(held & 255);
      [held, bits] = [held >> 8, bits - 8];
      if (block.length === 255) flush();
    }

    this.bytes.push(8);
    write(CLEAR);
    let prefix = colours[0];
    for (let i = 1; i < colours.length; i++) {
      const child = 256 * prefix + colours[i];
      if (children[child] >= 0) {
        prefix = children[child];
        continue;
      }
      write(prefix);
      prefix = colours[i];
      if (next < MOST) {
        children[child] = next;
        if (next === 1 << width) width += 1;
        next += 1;
      } else {
        write(CLEAR);
        children.fill(-1);
        [next, width] = [END + 1, 9];
      }
    }
    write(prefix);
    if (next === 1 << width && width < 12) width += 1;
    write(END);
    if (bits > 0) byte();
    if (block.length) flush();
    this.bytes.push(0);
  }

  file() {
    return new Blob([Uint8Array.from([...this.bytes, 0x3b])], { type: "image/gif" });
  }
}
