// The worker of one listening: pictures, report and recording, of the microphone or of a file.

import { Core, LIVE, PICTURES } from './core.js';
import { Recording } from './recording.js';

// Samples of a decoded file, at once; the page is told, and asked, this often, ms.
const STRETCH = 1 << 13;
const TELL_MS = 80;

const decoder = new TextDecoder();
const encoder = new TextEncoder();

let core = null;
let recording = null;
let told = 0;
let stopped = false;

const json = (code) => JSON.parse(decoder.decode(core.answered(code)));
const words = (why) => (why instanceof Uint8Array ? decoder.decode(why) : `${why.message ?? why}`);

function begin(settings, how, samples) {
  core.make(encoder.encode(JSON.stringify(settings)), how, samples);
  postMessage({ scale: json(core.wasm.scale()), fs: settings.fs, samples });
}

function tell(end = false) {
  const now = performance.now();
  if (!end && now - told < TELL_MS) return;
  told = now;
  const heard = json(core.wasm.heard());
  postMessage({ heard, columns: core.answered(core.wasm.columns()) });
}

function ended() {
  tell(true);
  const [advice, headline] = [json(core.wasm.advice()), json(core.wasm.headline())];
  postMessage({ ended: json(core.wasm.summary()), headline, advice, dropped_s: recording?.dropped_s ?? 0 });
}

// What the audio thread hands on.
function live({ samples, missing, speed, end }) {
  if (samples) {
    core.push(samples);
    recording.keep(samples);
  }
  if (missing) {
    core.wasm.missing(missing);
    recording.silence(missing);
  }
  if (speed) core.wasm.tell_speed(speed);
  if (end) ended();
  else tell();
}

// Does `step` until it says that there is no more, with ears for messages in between.
async function through(step) {
  while (!stopped) {
    const until = performance.now() + TELL_MS;
    while (performance.now() < until) {
      if (!step()) return ended();
    }
    tell();
    await new Promise((go) => setTimeout(go));
  }
  ended();
}

// A WAV file, read by the program itself: the very samples.
async function wav({ name, file, settings }) {
  const before = encoder.encode(name);
  const all = new Uint8Array(before.length + file.byteLength);
  all.set(before);
  all.set(new Uint8Array(file), before.length);
  core.bytes(all);
  const { fs, full_scale, samples, notices, channels } = json(core.wasm.open(before.length));
  postMessage({ notices, channels });
  begin({ ...settings, name, fs, full_scale }, PICTURES, samples);
  await through(() => {
    const code = core.wasm.step();
    core.answered(code);
    return code === 1;
  });
}

// Samples that the browser has decoded.
async function decoded({ name, samples, settings }) {
  core.bytes(encoder.encode(name));
  core.answered(core.wasm.judge(core.samples(samples), settings.fs));
  begin({ ...settings, name }, PICTURES, samples.length);
  let at = 0;
  await through(() => {
    core.push(samples.subarray(at, at + STRETCH));
    at += STRETCH;
    return at < samples.length;
  });
}

function listen({ settings, port }) {
  recording = new Recording(settings.fs);
  begin(settings, LIVE | PICTURES, -1);
  port.onmessage = ({ data }) => guarded(() => live(data));
}

async function asked(data) {
  if (data.program) core = new Core(data.program);
  if (data.file) await wav(data);
  else if (data.samples) await decoded(data);
  else if (data.port) listen(data);
  if (data.stop) stopped = true;
  if (data.want === 'report') {
    const page = core.answered(core.wasm.report(Date.now() / 1e3));
    postMessage({ answer: data.number, blob: new Blob([page], { type: 'text/html' }) });
  }
  if (data.want === 'sound') {
    postMessage({ answer: data.number, blob: await recording.wav() });
  }
  if (data.want === 'advice') {
    postMessage({ answer: data.number, advice: json(core.wasm.advice()) });
  }
}

async function guarded(work) {
  try {
    await work();
  } catch (why) {
    postMessage({ refused: words(why) });
  }
}

onmessage = ({ data }) => guarded(() => asked(data));
