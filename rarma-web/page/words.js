// What the page says where something is wrong: what, why, and what to do.

export const words_for = {
  no_listening:
    'This page may not listen: browsers allow it only to pages that came by https or from this computer. Open it there. Files can be opened all the same.',
  gone: 'The microphone has gone away. Connect it again and press Listen; what was heard until then is in the list below.',
  audio_thread:
    'The browser has ended the audio thread. Press Listen again; what was heard until then is in the list below.',
  slept: (s) =>
    `The computer has slept for ${s < 120 ? `${s.toFixed(0)} s` : `${(s / 60).toFixed(0)} min`}. Press Listen to go on; what was heard until then is in the list below.`,
  not_begun: 'Stopped before the microphone was there: nothing was heard.',
  paused: 'The browser has paused the sound (a call, a locked screen?). What is not heard meanwhile is counted as missing.',
  silent: (s) =>
    `Nothing but silence for ${s} s: unmute the input, turn its gain up, check its cable, or choose another one.`,
  interference: (names) =>
    `The browser keeps ${names.join(' and ')} on, which changes what is measured: see “What to do about gain control”.`,
  missing: (gaps, seconds) =>
    `${gaps === 1 ? 'A gap' : `${gaps} gaps`} in the sound, ${seconds.toFixed(2)} s in all: nothing is concluded there. Close other programs and tabs if it goes on.`,
  dropped: (seconds) =>
    `The recording holds the last hour: the first ${(seconds / 60).toFixed(0)} min are no longer in it. The report is of everything.`,
  undecodable: (name) =>
    `${name}: the browser finds no sound in it that it can decode (a video without sound, another kind of file, or one that is cut short). Convert it to WAV and open that.`,
  empty: (name) => `${name}: the file is empty. Copy it again, or record again.`,
  resampled: (name, fs) =>
    `${name}: decoded by the browser at ${fs} Hz. If it was compressed with loss (m4a, mp3, ogg, most videos), what is quiet beside loud lines may be missing: damping and weak modes are less certain than of a WAV.`,
  one_channel: (channels) => `The file has ${channels} channels; the first is listened to.`,
  worker: (why) => `A defect of the page: ${why}. Reload it, once what you need is saved.`,
};

// Why a microphone could not be opened.
export function not_opened(why) {
  switch (why.name) {
    case 'NotAllowedError':
    case 'SecurityError':
      return 'The page may not use the microphone: allow it by the sign beside the address (and in the system’s settings for this browser), then press Listen again. Nothing that was heard is lost.';
    case 'NotFoundError':
    case 'OverconstrainedError':
      return 'There is no such microphone: connect one or choose another input, then press Listen again. Files can be opened all the same.';
    case 'NotReadableError':
    case 'AbortError':
      return 'The microphone does not answer: another program may hold it. Close that, then press Listen again.';
    default:
      return `The microphone cannot be opened: ${why.message ?? why}.`;
  }
}
