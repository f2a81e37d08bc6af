// The page: what is pressed, dropped and shown.

import { Listening, STATES } from './listening.js';
import { Microphone, can_listen, inputs } from './microphone.js';
import { Pictures } from './pictures.js';
import { not_opened, words_for } from './words.js';

// The rate at which the browser decodes what is no WAV, Hz.
const DECODED_HZ = 48_000;
// Nothing but silence for so long is said, s.
const SILENT_S = 3;

const at = (id) => document.getElementById(id);
const decoder = new TextDecoder();

const pictures = new Pictures(at('sound'), at('damping'));
export const heard_so_far = [];

let program = null;
let now = null;
export let microphone = null;
let opened = 0;
// The number of the listening for which a microphone is being asked for.
let asking = 0;
let silent_said = false;

// The program, read once.
async function loaded() {
  program ??= new Uint8Array(await (await fetch('rarma.wasm')).arrayBuffer());
  return program;
}

const number = (id) => (at(id).value === '' ? null : Number(at(id).value));

// What the fields say; what cannot be is refused by the program, in words.
function settings() {
  const [low, high] = [number('low'), number('high')];
  const band = low === null && high === null ? null : [low ?? 300, high ?? 2500];
  const order = at('order').value.split(',').map(Number);
  return { rpm: number('speed'), teeth: number('teeth'), band, order };
}

function fields_are_good() {
  const odd = ['speed', 'teeth', 'low', 'high'].find((id) => !at(id).reportValidity());
  return odd === undefined;
}

function say(text, kind = 'note', bad = false) {
  const old = [...at('messages').children].find((line) => line.dataset.kind === kind && kind !== 'note');
  const line = old ?? document.createElement('p');
  line.dataset.kind = kind;
  line.className = bad ? 'bad' : '';
  if (line.textContent !== text) line.textContent = text;
  if (!old) at('messages').append(line);
  while (at('messages').children.length > 6) at('messages').firstChild.remove();
}

function hush() {
  at('messages').replaceChildren();
}

function listening(is) {
  at('listen').disabled = is;
  at('stop').disabled = !is;
}

function begin(name) {
  hush();
  silent_said = false;
  pictures.clear();
  at('advice').textContent = '';
  verdict('starting', 'starting', 'The model needs some tenths of a second of sound.');
  now = new Listening({ name, list: at('heard'), show });
  heard_so_far.push(now);
  at('nothing').hidden = true;
  return now;
}

function verdict(state, word, reason) {
  at('verdict').dataset.state = state;
  if (at('word').textContent !== word) at('word').textContent = word;
  at('reason').textContent = reason;
}

// What the monitor says, from whichever thread.
function told({ state, reason, t, alarms, missing, begun }, fs) {
  if (state) verdict(state, state, `${reason}.`);
  const alarm = alarms.at(-1);
  const stands = alarm && alarm.off == null;
  const calls = alarm
    ? ` ${stands ? 'Chatter called' : 'Last chatter'}: ${alarm.f.toFixed(1)} Hz from ${alarm.on.toFixed(3)} s.`
    : '';
  at('time').textContent = begun ? `${t.toFixed(1)} s heard.${calls}` : 'Waiting for the first sound.';
  if (missing.gaps > 0) say(words_for.missing(missing.gaps, missing.samples / fs), 'missing');
}

function level({ level }) {
  if (!level) return;
  at('level').value = level.rms_dbfs;
  at('level-words').textContent = `rms ${level.rms_dbfs.toFixed(0)} dBFS, peak ${level.peak_dbfs.toFixed(0)} dBFS`;
  for (const warning of level.warnings) {
    say(`The input: ${warning}`, warning.slice(0, 8), true);
  }
}

function modes({ points }) {
  const point = points.at(-1);
  if (!point) return;
  const row = ({ f, f_sd, zeta, zeta_sd, label, harmonic }) => {
    const made = document.createElement('tr');
    const source = harmonic ? `${label}, ${harmonic} × speed` : label;
    const cells = [
      `${f.toFixed(1)} ± ${f_sd.toFixed(1)}`,
      `${(100 * zeta).toFixed(2)} ± ${(100 * zeta_sd).toFixed(2)}`,
      source,
    ];
    made.append(...cells.map((text) => Object.assign(document.createElement('td'), { textContent: text })));
    return made;
  };
  at('modes').replaceChildren(...point.modes.map(row));
}

// What a worker says.
function show(listening_, data) {
  if (data.forgotten) return forgotten(listening_);
  if (listening_ !== now) return;
  if (data.notices) {
    data.notices.forEach((text) => say(`${now.name}: ${text}`));
    if (data.channels > 1) say(words_for.one_channel(data.channels));
  }
  if (data.scale) {
    now.fs = data.fs;
    if (data.scale.warning) say(`${now.name}: ${data.scale.warning}; choose another microphone.`, 'rate', true);
    pictures.begin(data.scale, data.samples < 0 ? null : data.samples / data.fs);
  }
  if (data.heard) {
    pictures.take(data.heard, data.columns);
    level(data.heard);
    modes(data.heard);
    if (!now.live) told(data.heard, now.fs);
    advise(data.heard);
  }
  if (data.ended) ended(data);
  if (data.refused) refused(data.refused);
}

// A new alarm: what to turn instead.
async function advise({ alarms_so_far }) {
  if (alarms_so_far === (now.advised ?? 0)) return;
  now.advised = alarms_so_far;
  const asked = now;
  const { advice } = await asked.ask('advice');
  if (asked === now) at('advice').textContent = advice.join(' ');
}

function ended({ ended, headline, advice, dropped_s }) {
  at('advice').textContent = advice.join(' ');
  if (dropped_s > 0) say(words_for.dropped(dropped_s));
  const words = { bad: 'chatter', careful: 'warning', good: 'no chatter', unknown: 'no verdict' };
  verdict(STATES[headline.tone], words[headline.tone], `${headline.text}.`);
  at('time').textContent = `${(ended.samples / ended.fs).toFixed(1)} s heard, and at an end.`;
  listening(false);
}

function refused(text) {
  say(text, 'refused', true);
  verdict('invalid', 'no verdict', 'See the message.');
  if (now && !now.summary && !now.last) now.forget();
  listening(false);
}

function forgotten(listening_) {
  const k = heard_so_far.indexOf(listening_);
  if (k >= 0) heard_so_far.splice(k, 1);
  if (listening_ === now) now = null;
  at('nothing').hidden = heard_so_far.length > 0;
}

// The audio thread says something.
function hear({ heard, blocks, refused: why, paused, slept_s }) {
  if (paused) say(words_for.paused, 'paused');
  if (slept_s && microphone) {
    say(words_for.slept(slept_s), 'gone', true);
    stop();
  }
  if (why) say(decoder.decode(why), 'refused', true);
  if (!heard || !now) return;
  const told_now = JSON.parse(decoder.decode(heard));
  now.by_ear = told_now;
  told(told_now, now.fs);
  const quiet = !told_now.begun && blocks * 128 > SILENT_S * now.fs;
  if (quiet && !silent_said) {
    silent_said = true;
    say(words_for.silent(SILENT_S), 'silent', true);
  }
  if (told_now.begun && silent_said) {
    silent_said = false;
    at('messages').querySelector('[data-kind=silent]')?.remove();
  }
}

// Pressed: the microphone.
export async function listen() {
  if (!fields_are_good()) return;
  if (!can_listen()) return say(words_for.no_listening, 'refused', true);
  listening(true);
  const mine = (opened += 1);
  asking = mine;
  try {
    await loaded();
    const session = begin('microphone');
    session.live = true;
    const wanted = { device: at('device').value, program, settings: settings(), desk: session.worker };
    const gone = (text) => {
      say(text, 'gone', true);
      stop();
    };
    const there = await Microphone.open({ ...wanted, hear, gone });
    // Stopped meanwhile, while the browser asked.
    if (mine !== opened) return await there.stop();
    microphone = there;
    session.name = microphone.name;
    session.entry('listening …');
    const names = microphone.interference();
    if (names.length > 0) say(words_for.interference(names), 'interference', true);
    await offer_inputs();
  } catch (why) {
    if (mine !== opened) return;
    refused(not_opened(why));
  } finally {
    if (asking === mine) asking = 0;
  }
}

// Pressed: the end. What was heard stays.
export async function stop() {
  at('stop').disabled = true;
  const ending = microphone;
  microphone = null;
  if (ending) return await ending.stop();
  if (!asking) return now?.worker.postMessage({ stop: true });
  opened += 1;
  asking = 0;
  refused(words_for.not_begun);
}

// Chosen or dropped: a file.
export async function open(file) {
  if (microphone || asking) return say('Press Stop first, then open the file.', 'refused', true);
  if (!fields_are_good()) return;
  listening(true);
  opened += 1;
  await loaded();
  const session = begin(file.name);
  try {
    if (file.size === 0) throw words_for.empty(file.name);
    const bytes = await file.arrayBuffer();
    const common = { program, name: file.name, settings: settings() };
    if (is_wav(bytes)) {
      session.worker.postMessage({ ...common, file: bytes }, [bytes]);
      return;
    }
    const samples = await decoded(file.name, bytes);
    say(words_for.resampled(file.name, DECODED_HZ));
    common.settings.fs = DECODED_HZ;
    session.worker.postMessage({ ...common, samples }, [samples.buffer]);
  } catch (why) {
    refused(typeof why === 'string' ? why : `${file.name}: ${why.message ?? why}`);
  }
}

function is_wav(bytes) {
  const first = String.fromCharCode(...new Uint8Array(bytes, 0, Math.min(4, bytes.byteLength)));
  return first === 'RIFF' || first === 'RF64';
}

async function decoded(name, bytes) {
  try {
    const sound = await new OfflineAudioContext(1, 1, DECODED_HZ).decodeAudioData(bytes);
    return sound.getChannelData(0).slice();
  } catch {
    throw words_for.undecodable(name);
  }
}

async function offer_inputs() {
  const chosen = at('device').value;
  const options = (await inputs()).filter(({ label }) => label).map(({ deviceId, label }) => new Option(label, deviceId));
  at('device').replaceChildren(new Option('the usual one', ''), ...options);
  at('device').value = chosen;
}

at('listen').onclick = listen;
at('stop').onclick = stop;
at('file').onchange = async ({ target }) => {
  const [file] = target.files;
  if (file) await open(file);
  target.value = '';
};
at('speed').onchange = () => {
  const speed = number('speed');
  if (microphone && speed !== null && at('speed').reportValidity()) microphone.tell_speed(speed);
};
at('controls').onsubmit = (event) => event.preventDefault();
at('gain').onclick = () => at('gain-help').showModal();

addEventListener('dragover', (event) => {
  event.preventDefault();
  document.body.classList.add('over');
});
addEventListener('dragleave', (event) => {
  if (!event.relatedTarget) document.body.classList.remove('over');
});
addEventListener('drop', (event) => {
  event.preventDefault();
  document.body.classList.remove('over');
  const [file] = event.dataTransfer.files;
  if (file) open(file);
});
addEventListener('beforeunload', (event) => {
  if (microphone || heard_so_far.some(({ live, saved, last }) => live && !saved && last)) event.preventDefault();
});

async function keep_offline() {
  if (!navigator.serviceWorker) return;
  await navigator.serviceWorker.register('sw.js');
  await navigator.serviceWorker.ready;
  at('offline').textContent = 'Kept: it works without a network.';
}

if (!can_listen()) say(words_for.no_listening, 'refused');
navigator.mediaDevices?.addEventListener?.('devicechange', offer_inputs);
pictures.draw();
await Promise.all([loaded(), offer_inputs(), keep_offline()]).catch((why) => say(words_for.worker(why.message), 'refused', true));
