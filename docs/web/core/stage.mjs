/** @typedef {import("./plane.mjs").Point} Point */

/** What can be taken hold of, by mouse, finger and keyboard.
 * @typedef {{ name: string, label: string, color: string, place: Point, move(to: Point): void,
 *   step?: number }} Handle */

/** A picture of the world, in the world's unit, and buttons over it that can be dragged. */
export class Stage {
  /** @param {HTMLElement} element Holds the canvas and the buttons. */
  constructor(element) {
    this.element = element;
    this.canvas =
      element.querySelector("canvas") ?? element.appendChild(document.createElement("canvas"));
    this.pen = this.canvas.getContext("2d");
    /** @type {Map<string, { button: HTMLButtonElement, handle: Handle }>} */
    this.buttons = new Map();
    /** @type {Map<string, HTMLCanvasElement>} */
    this.labels = new Map();
    this.isAsked = false; // for a frame
    this.drawn = "";
    /** @type {() => void} */
    this.redraw = () => {}; // what is called when another size has left it blank
    this.fit([0, 0], [1, 1], false);
    new ResizeObserver(() => {
      this.#resize();
      this.redraw();
    }).observe(element);
  }

  /** Show a part of the world. @param {Point} low @param {Point} high
   * @param {boolean} isDown Whether y points down. */
  fit(low, high, isDown) {
    this.low = low;
    this.high = high;
    this.isDown = isDown;
    this.element.style.setProperty("--shape", String((high[0] - low[0]) / (high[1] - low[1])));
    this.#resize();
  }

  #resize() {
    this.drawn = ""; // it will be blank
    const { width, height } = this.element.getBoundingClientRect();
    const dots = (this.dots = Math.min(window.devicePixelRatio || 1, 2));
    this.canvas.width = Math.max(1, Math.round(width * dots));
    this.canvas.height = Math.max(1, Math.round(height * dots));
    this.pen.setTransform(dots, 0, 0, dots, 0, 0);
    const scales = [width / (this.high[0] - this.low[0]), height / (this.high[1] - this.low[1])];
    this.scale = Math.max(Math.min(...scales), 1e-9);
    this.size = [width, height];
    this.left = (width - this.scale * (this.high[0] - this.low[0])) / 2;
    this.top = (height - this.scale * (this.high[1] - this.low[1])) / 2;
  }

  /** @param {Point} place @returns {Point} */
  toScreen([x, y]) {
    const down = this.isDown ? y - this.low[1] : this.high[1] - y;
    return [this.left + this.scale * (x - this.low[0]), this.top + this.scale * down];
  }

  /** @param {Point} dot @returns {Point} */
  toWorld([left, top]) {
    const down = (top - this.top) / this.scale;
    return [
      this.low[0] + (left - this.left) / this.scale,
      this.isDown ? this.low[1] + down : this.high[1] - down,
    ];
  }

  /** Draw at the next frame, however often that is asked for. */
  soon() {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      this.redraw();
    });
  }

  /** Whether a picture would be another one than before. @param {unknown} what Shows, to a thousandth. */
  differs(what) {
    const round = (/** @type {string} */ _, /** @type {any} */ value) =>
      typeof value === "number" ? Math.round(1000 * value) : value;
    const words = JSON.stringify([what, this.size], round);
    const differs = words !== this.drawn;
    this.drawn = words;
    return differs;
  }

  /** What is drawn, as a picture of its own, which costs little to show again. @param {() => void} draw */
  picture(draw) {
    const [pen, picture] = [this.pen, document.createElement("canvas")];
    [picture.width, picture.height] = [this.canvas.width, this.canvas.height];
    this.pen = picture.getContext("2d");
    this.pen.setTransform(pen.getTransform());
    draw();
    this.pen = pen;
    return picture;
  }

  /** @param {HTMLCanvasElement} picture */
  show(picture) {
    this.pen.drawImage(picture, 0, 0, this.size[0], this.size[1]);
  }

  /** @param {string} color */
  clear(color) {
    this.pen.fillStyle = color;
    this.pen.fillRect(0, 0, this.size[0] + 1, this.size[1] + 1); // a half dot at the edge is a whole one
  }

  /** @param {Point[]} corners @param {{ fill?: string, edge?: string, width?: number, open?: boolean,
   *   dash?: number[] }} looks */
  polygon(corners, { fill, edge, width = 1.5, open = false, dash = [] }) {
    const { pen } = this;
    pen.beginPath();
    for (const corner of corners) pen.lineTo(...this.toScreen(corner));
    if (!open) pen.closePath();
    if (fill) (([pen.fillStyle] = [fill]), pen.fill());
    if (!edge) return;
    [pen.strokeStyle, pen.lineWidth, pen.lineJoin, pen.lineCap] = [edge, width, "round", "round"];
    pen.setLineDash(dash);
    pen.stroke();
    pen.setLineDash([]);
  }

  /** A box between two corners. @param {Point} low @param {Point} high
   * @param {{ fill?: string, edge?: string, width?: number }} looks */
  box([left, low], [right, high], looks) {
    this.polygon([[left, low], [right, low], [right, high], [left, high]], looks);
  }

  /** @param {Point[]} points @param {string} color @param {number} [width] @param {number[]} [dash] */
  line(points, color, width = 2, dash = []) {
    this.polygon(points, { edge: color, width, dash, open: true });
  }

  /** A straight line between two points. @param {Point} start @param {Point} end @param {string} color
   * @param {number} [width] @param {number[]} [dash] */
  stroke(start, end, color, width, dash) {
    this.line([start, end], color, width, dash);
  }

  /** @param {Point} place @param {number} radius In the world's unit. @param {string} fill @param {string} [edge] */
  disc(place, radius, fill, edge) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(...this.toScreen(place), Math.max(radius * this.scale, 0.5), 0, 2 * Math.PI);
    pen.fillStyle = fill;
    pen.fill();
    if (edge) (([pen.strokeStyle, pen.lineWidth] = [edge, 1.5]), pen.stroke());
  }

  /** An ellipse of two standard deviations. @param {Point} mean @param {ArrayLike<number>} covariance (4,)
   * @param {string} color */
  spread(mean, covariance, color) {
    const [xx, xy, , yy] = Array.from(covariance);
    const middle = (xx + yy) / 2;
    const half = Math.hypot((xx - yy) / 2, xy);
    const [long, short] = [middle + half, middle - half].map(
      (v) => 2 * this.scale * Math.sqrt(Math.max(v, 0)),
    );
    const angle = Math.atan2(2 * xy, xx - yy) / 2;
    const { pen } = this;
    pen.beginPath();
    pen.ellipse(...this.toScreen(mean), long, short, this.isDown ? angle : -angle, 0, 2 * Math.PI);
    pen.globalAlpha = 0.25;
    pen.fillStyle = color;
    pen.fill();
    pen.globalAlpha = 1;
    [pen.strokeStyle, pen.lineWidth] = [color, 1.5];
    pen.stroke();
  }

  /** An arrow from a place along a direction of the world, so many dots long.
   * @param {Point} from @param {Point} way @param {number} length @param {string} color @param {number} [width] */
  arrow(from, way, length, color, width = 4) {
    const size = Math.hypot(...way);
    if (size < 1e-12 || length < 2) return;
    const [x, y] = this.toScreen(from);
    const [dx, dy] = [way[0] / size, (this.isDown ? 1 : -1) * (way[1] / size)];
    const head = Math.min(4 + 2 * width, length);
    const [baseX, baseY] = [x + (length - head) * dx, y + (length - head) * dy];
    const { pen } = this;
    [pen.strokeStyle, pen.fillStyle, pen.lineWidth, pen.lineCap] = [color, color, width, "butt"];
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(baseX, baseY);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x + length * dx, y + length * dy);
    pen.lineTo(baseX - 0.5 * head * dy, baseY + 0.5 * head * dx);
    pen.lineTo(baseX + 0.5 * head * dy, baseY - 0.5 * head * dx);
    pen.fill();
  }

  /** Words beside a place, so many dots off. @param {string} words @param {Point} place @param {string} color
   * @param {Point} [off] */
  text(words, place, color, [right, down] = [0, 0]) {
    const [x, y] = this.toScreen(place);
    const label = this.#label(words, color);
    const [width, height] = [label.width / this.dots, label.height / this.dots];
    const whole = (/** @type {number} */ at) => Math.round(at * this.dots) / this.dots; // sharp letters
    this.pen.drawImage(label, whole(x + right - width / 2), whole(y + down - height / 2), width, height);
  }

  /** Words as a picture: letters with an edge are slow to paint. @param {string} words @param {string} color */
  #label(words, color) {
    const name = `${words} ${color} ${this.dots}`;
    const known = this.labels.get(name);
    if (known) return known;

    const label = document.createElement("canvas");
    const pen = label.getContext("2d");
    const font = "600 13px system-ui, sans-serif";
    pen.font = font;
    label.width = this.dots * Math.ceil(pen.measureText(words).width + 8);
    label.height = this.dots * 24;
    pen.scale(this.dots, this.dots);
    [pen.font, pen.textAlign, pen.textBaseline, pen.lineWidth] = [font, "center", "middle", 4];
    [pen.strokeStyle, pen.fillStyle, pen.lineJoin] = ["rgb(255 255 255 / 85%)", color, "round"];
    const middle = /** @type {Point} */ ([label.width / this.dots / 2, 12]);
    pen.strokeText(words, ...middle);
    pen.fillText(words, ...middle);
    this.labels.set(name, label);
    return label;
  }

  /** Put a button on everything that can be taken hold of. @param {Handle[]} handles */
  hold(handles) {
    const names = new Set(handles.map((handle) => handle.name));
    for (const [name, { button }] of this.buttons) {
      if (names.has(name)) continue;
      button.remove();
      this.buttons.delete(name);
    }
    for (const handle of handles) {
      const held = this.buttons.get(handle.name) ?? this.#add(handle);
      held.handle = handle;
      const [x, y] = this.toScreen(handle.place);
      held.button.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }

  /** @param {Handle} handle */
  #add(handle) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "handle";
    button.dataset.name = handle.name;
    button.style.setProperty("--color", handle.color);
    button.setAttribute("aria-label", `${handle.label}: drag it, or move it with the arrow keys`);
    button.title = handle.label;
    const held = { button, handle };
    this.buttons.set(handle.name, held);

    // Where it was taken hold of stays under the finger.
    let grip = /** @type {Point | null} */ (null);
    const under = (/** @type {PointerEvent} */ event) => {
      const frame = this.element.getBoundingClientRect();
      return this.toWorld([event.clientX - frame.left, event.clientY - frame.top]);
    };
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      const [x, y] = under(event);
      grip = [held.handle.place[0] - x, held.handle.place[1] - y];
    });
    button.addEventListener("pointermove", (event) => {
      if (!grip) return;
      const [x, y] = under(event);
      held.handle.move([x + grip[0], y + grip[1]]);
    });
    for (const end of ["pointerup", "pointercancel"])
      button.addEventListener(end, () => (grip = null));

    button.addEventListener("keydown", (event) => {
      const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      const way = ways[/** @type {keyof typeof ways} */ (event.key)];
      if (!way) return;
      event.preventDefault();
      const length =
        (event.shiftKey ? 5 : 1) * (held.handle.step ?? 0.02 * (this.high[0] - this.low[0]));
      const { handle } = held;
      const [x, y] = handle.place;
      handle.place = [x + length * way[0], y + (this.isDown ? -1 : 1) * length * way[1]];
      handle.move(handle.place); // from there the next press goes on, though nothing is drawn yet
    });
    this.element.append(button);
    return held;
  }
}
