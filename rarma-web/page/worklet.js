// The audio thread: hears, judges at once, and hands the sound on to the worker.

import { Core, LIVE } from './core.js';

// Samples that are handed on at once: 43 ms at 48 kHz.
const HANDFUL = 2048;
// The page is told this often, s, and at once where it matters.
const TELL_S = 0.1;
// A gap of so long, s, is no gap: the computer has slept.
const SLEPT_S = 60;

class Ear extends AudioWorkletProcessor {
  constructor({ processorOptions: { program, settings } }) {
    super();
    this.program = program;
    this.settings = settings;
    this.core = new Core(program);
    this.core.make(settings, LIVE);
    // Until the worker's port has come, what is for it waits.
    this.desk = null;
    this.waiting = [];
    this.handful = new Float32Array(HANDFUL);
    this.held = 0;
    this.silence = new Float32Array(128);
    this.untold = 0;
    this.blocks = 0;
    this.stopped = false;
    this.port.onmessage = ({ data }) => this.asked(data);
  }

  asked({ desk, speed, stop, measure }) {
    if (desk) {
      this.desk = desk;
      this.waiting.splice(0).forEach((message) => desk.postMessage(message));
    }
    if (speed) {
      this.handOn();
      if (this.core.wasm.tell_speed(speed) < 0) {
        this.port.postMessage({ refused: this.core.answer() });
      } else {
        this.toDesk({ speed });
      }
    }
    if (measure) this.port.postMessage({ measured: this.measured(measure) });
    if (stop) {
      this.handOn();
      this.stopped = true;
      // It ends, also where there is nothing more to tell.
      try {
        this.tell();
      } finally {
        this.toDesk({ end: true });
      }
    }
  }

  process([input]) {
    if (this.stopped) return false;
    const samples = input?.[0] ?? this.silence;
    if (currentFrame > this.next) this.lost(currentFrame - this.next);
    this.next = currentFrame + samples.length;
    this.lost(this.core.wasm.note_clock(this.next, Date.now() / 1e3));
    const urgent = this.core.push(samples);
    this.blocks += 1;
    this.keep(samples);
    this.untold += samples.length;
    if (urgent || this.untold >= TELL_S * sampleRate) this.tell();
    return true;
  }

  // What so many blocks take, ms: by a second program on sound that was just heard. There is no finer
  // clock here than one of whole milliseconds, and a block takes a small part of one.
  measured(blocks) {
    const core = new Core(this.program);
    core.make(this.settings, LIVE);
    const sound = this.handful.slice();
    const begun = Date.now();
    for (let k = 0; k < blocks; k += 1) {
      const at = (128 * k) % (HANDFUL - 127);
      core.push(sound.subarray(at, at + 128));
    }
    return Date.now() - begun;
  }

  // So many samples never came.
  lost(samples) {
    if (!(samples > 0)) return;
    if (samples > SLEPT_S * sampleRate) {
      this.port.postMessage({ slept_s: samples / sampleRate });
      return;
    }
    this.handOn();
    this.core.wasm.missing(samples);
    this.toDesk({ missing: samples });
  }

  keep(samples) {
    if (this.held + samples.length > HANDFUL) this.handOn();
    this.handful.set(samples, this.held);
    this.held += samples.length;
  }

  toDesk(message) {
    if (this.desk) this.desk.postMessage(message);
    else this.waiting.push(message);
  }

  handOn() {
    if (this.held === 0) return;
    this.toDesk({ samples: this.handful.slice(0, this.held) });
    this.held = 0;
  }

  tell() {
    this.untold = 0;
    this.port.postMessage({ heard: this.core.answered(this.core.wasm.heard()), blocks: this.blocks });
  }
}

registerProcessor('ear', Ear);
