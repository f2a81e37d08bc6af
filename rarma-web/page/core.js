// The program behind the page, called with numbers and places in memory (rarma-web/src/exports.rs).
// Used in the audio thread, too, where a browser has neither text decoders nor a clock of its own:
// settings and answers are bytes here.

export const LIVE = 1;
export const PICTURES = 2;

export class Core {
  constructor(program) {
    this.wasm = new WebAssembly.Instance(new WebAssembly.Module(program), {}).exports;
  }

  // The memory moves when it grows: looked up each time.
  bytes(bytes) {
    const at = this.wasm.bytes_room(bytes.length);
    new Uint8Array(this.wasm.memory.buffer, at, bytes.length).set(bytes);
  }

  samples(samples) {
    const at = this.wasm.samples_room(samples.length);
    new Float32Array(this.wasm.memory.buffer, at, samples.length).set(samples);
    return samples.length;
  }

  answer() {
    const { memory, answer, answer_length } = this.wasm;
    return new Uint8Array(memory.buffer, answer(), answer_length()).slice();
  }

  // What a call answered; what it refused is thrown, as bytes.
  answered(code) {
    const answer = this.answer();
    if (code < 0) throw answer;
    return answer;
  }

  make(settings, how, samples = -1) {
    this.bytes(settings);
    this.answered(this.wasm.make(how, samples));
  }

  push(samples) {
    return this.wasm.push(this.samples(samples)) === 1;
  }
}
