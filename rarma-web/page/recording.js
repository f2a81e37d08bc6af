// The sound of the microphone, kept to be saved: in parts that the browser may put on its disk.

// Samples of a part, and how much is kept, s; older parts go.
const PART = 1 << 19;
const MOST_S = 3600;

export class Recording {
  constructor(fs) {
    this.fs = fs;
    this.parts = [];
    this.part = new Float32Array(PART);
    this.held = 0;
    // Every sample is a whole number of 16 bits, as microphones mostly give them.
    this.whole = true;
    this.begun = false;
    this.dropped_s = 0;
  }

  keep(samples) {
    for (const x of samples) {
      // The monitor's time begins with the first sound; the recording's as well.
      this.begun ||= x !== 0;
      if (this.begun) this.put(x);
    }
  }

  silence(samples) {
    if (!this.begun) return;
    for (let n = Math.min(samples, MOST_S * this.fs); n > 0; n -= 1) this.put(0);
  }

  put(x) {
    this.whole &&= Number.isInteger(x * 32768) && x < 1;
    this.part[this.held] = x;
    this.held += 1;
    if (this.held < PART) return;
    this.parts.push(new Blob([this.part]));
    this.held = 0;
    if ((this.parts.length * PART) / this.fs > MOST_S) {
      this.parts.shift();
      this.dropped_s += PART / this.fs;
    }
  }

  // A WAV file: of 16 bits where that loses nothing, else of floats.
  async wav() {
    const all = [...this.parts, new Blob([this.part.subarray(0, this.held)])];
    const data = [];
    for (const part of all) {
      const samples = new Float32Array(await part.arrayBuffer());
      const packed = this.whole ? Int16Array.from(samples, (x) => x * 32768) : samples;
      data.push(new Blob([packed]));
    }
    return new Blob([this.header(data), ...data], { type: 'audio/wav' });
  }

  header(data) {
    const length = data.reduce((sum, part) => sum + part.size, 0);
    const width = this.whole ? 2 : 4;
    const view = new DataView(new ArrayBuffer(44));
    const name = (at, letters) => [...letters].forEach((c, k) => view.setUint8(at + k, c.charCodeAt(0)));
    name(0, 'RIFF');
    view.setUint32(4, 36 + length, true);
    name(8, 'WAVEfmt ');
    view.setUint32(16, 16, true);
    view.setUint16(20, this.whole ? 1 : 3, true);
    view.setUint16(22, 1, true);
    view.setUint32(24, this.fs, true);
    view.setUint32(28, this.fs * width, true);
    view.setUint16(32, width, true);
    view.setUint16(34, 8 * width, true);
    name(36, 'data');
    view.setUint32(40, length, true);
    return view.buffer;
  }
}
