// The two pictures: the sound over time and frequency, and the damping of every mode.

// Seconds of live sound that are shown.
const SHOWN_S = 20;
// Columns and points kept; of more, neighbours become one.
const MOST = 2048;
// Damping ratios at the ends of the scale, and of its lines.
const LOW = -0.02;
const HIGH = 0.1;
const LINES = [0, 0.02, 0.04, 0.06, 0.08, 0.1];
// Room for numbers left of the pictures and below them, CSS pixels.
const LEFT = 46;
const BELOW = 20;

const LABELS = { 'self-excited': '--self', structural: '--struct', forced: '--forced' };

export class Pictures {
  constructor(sound, damping) {
    this.sound = sound;
    this.damping = damping;
    this.clear();
    const again = () => this.draw();
    new ResizeObserver(again).observe(sound);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
  }

  clear() {
    this.scale = null;
    this.columns = [];
    this.points = [];
    this.stride = 1;
    this.open = null;
    this.joined = 0;
    this.length_s = null;
    this.t = 0;
  }

  begin(scale, seconds) {
    this.clear();
    this.scale = scale;
    this.length_s = seconds;
  }

  // Columns one after the other, and what was said meanwhile.
  take(heard, values) {
    this.t = heard.t;
    const { rows } = this.scale;
    for (let at = 0; at < values.length; at += rows) this.column(values.subarray(at, at + rows));
    this.points.push(...heard.points);
    if (this.length_s === null) {
      const from = this.t - SHOWN_S - 1;
      while (this.points.length > 0 && this.points[0].t < from) this.points.shift();
      const most = Math.ceil((SHOWN_S + 1) / this.scale.step_s);
      if (this.columns.length > most) this.columns.splice(0, this.columns.length - most);
    } else if (this.points.length > 2 * MOST) {
      this.points = this.points.filter((_, k) => k % 2 === 0);
    }
    this.ask();
  }

  // Of a long file neighbours are joined, the louder value of each.
  column(values) {
    if (this.open) this.open = louder(this.open, values);
    else this.open = values.slice();
    this.joined += 1;
    if (this.joined < this.stride) return;
    this.columns.push(this.open);
    this.open = null;
    this.joined = 0;
    if (this.length_s === null || this.columns.length < MOST) return;
    const all = this.columns;
    this.columns = all.filter((_, k) => k % 2 === 0).map((values, k) => louder(values, all[2 * k + 1]));
    this.stride *= 2;
  }

  // Once before the browser shows the page again, however often asked.
  ask() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  window() {
    if (this.length_s !== null) return [0, Math.max(this.length_s, 0.1)];
    const end = Math.max(this.t, SHOWN_S);
    return [end - SHOWN_S, end];
  }

  draw() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    this.draw_sound(colour);
    this.draw_damping(colour);
  }

  draw_sound(colour) {
    const frame = new Frame(this.sound, this.window(), colour);
    if (!this.scale) return frame.axes([], []);
    const { rows, top_hz, step_s, band_hz } = this.scale;
    frame.range(0, top_hz);
    const { width, height } = frame;
    const image = new ImageData(Math.max(1, Math.round(width)), rows);
    const palette = this.palette(colour);
    const [from, to] = this.window();
    const seconds = step_s * this.stride;
    const first = this.length_s === null ? this.t - this.columns.length * seconds : 0;
    this.columns.forEach((values, k) => {
      const at = (t) => Math.round(((t - from) / (to - from)) * image.width);
      const start = Math.max(0, at(first + k * seconds));
      const end = Math.min(image.width, Math.max(start + 1, at(first + (k + 1) * seconds)));
      for (let row = 0; row < rows; row += 1) {
        const rgb = palette[values[row]];
        for (let x = start; x < end; x += 1) {
          const place = 4 * ((rows - 1 - row) * image.width + x);
          image.data.set(rgb, place);
        }
      }
    });
    frame.bitmap(image);
    const step = top_hz > 4000 ? 1000 : 500;
    const lines = [];
    for (let hz = 0; hz <= top_hz; hz += step) lines.push([hz, `${hz}`]);
    frame.axes(lines, band_hz);
  }

  draw_damping(colour) {
    const frame = new Frame(this.damping, this.window(), colour);
    frame.range(LOW, HIGH);
    frame.axes(LINES.map((z) => [z, `${(100 * z).toFixed(0)}`]), [this.scale?.threshold ?? 0.01]);
    for (const { t, modes } of this.points) {
      for (const { zeta, zeta_sd, label } of modes) {
        // What is damped beyond the scale does not matter here.
        if (zeta > HIGH) continue;
        const name = LABELS[label] ?? '--grey';
        frame.spread(t, zeta - zeta_sd, zeta + zeta_sd, colour(name));
        frame.mark(t, zeta, label, colour(name));
      }
    }
  }

  // From paper to ink through the steps of the report's scale of one hue.
  palette(colour) {
    const steps = ['--paper', '--s0', '--s2', '--s4', '--s6', '--s7', '--ink'].map((name) => rgb(colour(name)));
    return Array.from({ length: 256 }, (_, v) => {
      const at = (v / 255) * (steps.length - 1);
      const k = Math.min(Math.floor(at), steps.length - 2);
      const part = at - k;
      return [...steps[k].map((a, i) => Math.round(a + part * (steps[k + 1][i] - a))), 255];
    });
  }
}

const louder = (a, b) => a.map((v, k) => Math.max(v, b[k]));
const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// A canvas with a scale of time and one of something else.
class Frame {
  constructor(canvas, [from, to], colour) {
    const dense = devicePixelRatio || 1;
    const { clientWidth, clientHeight } = canvas;
    canvas.width = Math.round(clientWidth * dense);
    canvas.height = Math.round(clientHeight * dense);
    this.paper = canvas.getContext('2d');
    this.paper.scale(dense, dense);
    this.from = from;
    this.to = to;
    this.colour = colour;
    this.width = Math.max(1, clientWidth - LEFT - 2);
    this.height = Math.max(1, clientHeight - BELOW - 4);
    this.range(0, 1);
  }

  range(low, high) {
    this.low = low;
    this.high = high;
  }

  x(t) {
    return LEFT + (this.width * (t - this.from)) / (this.to - this.from);
  }

  y(v) {
    const part = (v - this.low) / (this.high - this.low);
    return 4 + this.height * (1 - Math.min(1, Math.max(0, part)));
  }

  bitmap(image) {
    const small = new OffscreenCanvas(image.width, image.height);
    small.getContext('2d').putImageData(image, 0, 0);
    this.paper.imageSmoothingEnabled = false;
    this.paper.drawImage(small, LEFT, 4, this.width, this.height);
  }

  // Lines across at `values`, dashed ones at `edges`, and seconds below.
  axes(values, edges) {
    const { paper, colour } = this;
    paper.font = '12px system-ui, sans-serif';
    paper.lineWidth = 1;
    paper.textBaseline = 'middle';
    paper.textAlign = 'right';
    values.forEach(([value, name]) => {
      paper.strokeStyle = colour('--line');
      this.across(value, 0.6);
      paper.fillStyle = colour('--soft');
      paper.fillText(name, LEFT - 5, Math.max(10, this.y(value)));
    });
    paper.strokeStyle = colour('--ink');
    paper.setLineDash([6, 5]);
    edges.forEach((value) => this.across(value, 1));
    paper.setLineDash([]);
    paper.fillStyle = colour('--soft');
    paper.textAlign = 'center';
    const step = [0.5, 1, 2, 5, 10, 30, 60, 300, 600, 1800].find((s) => (this.to - this.from) / s <= 8) ?? 3600;
    for (let t = Math.ceil(this.from / step) * step; t <= this.to; t += step) {
      const name = `${Number(t.toFixed(1))}${t + step > this.to ? ' s' : ''}`;
      paper.fillText(name, Math.min(this.x(t), LEFT + this.width - 14), this.height + 4 + BELOW / 2);
    }
  }

  across(value, opacity) {
    this.paper.globalAlpha = opacity;
    this.paper.beginPath();
    this.paper.moveTo(LEFT, this.y(value));
    this.paper.lineTo(LEFT + this.width, this.y(value));
    this.paper.stroke();
    this.paper.globalAlpha = 1;
  }

  spread(t, low, high, tone) {
    this.paper.globalAlpha = 0.22;
    this.paper.fillStyle = tone;
    const top = this.y(high);
    this.paper.fillRect(this.x(t) - 1.5, top, 3, Math.max(1, this.y(low) - top));
    this.paper.globalAlpha = 1;
  }

  // Shapes differ as well as colours.
  mark(t, value, label, tone) {
    const [x, y] = [this.x(t), this.y(value)];
    const { paper } = this;
    paper.fillStyle = tone;
    paper.beginPath();
    if (label === 'self-excited') {
      paper.moveTo(x, y - 4.5);
      paper.lineTo(x + 4, y + 3);
      paper.lineTo(x - 4, y + 3);
    } else if (label === 'forced') {
      paper.rect(x - 2, y - 2, 4, 4);
    } else {
      paper.arc(x, y, 2.2, 0, 7);
    }
    paper.fill();
  }
}
