// From the microphone to the audio thread and the worker.

import { words_for } from './words.js';

// What browsers do to voices must not be done to machines.
const PLAIN = { echoCancellation: false, noiseSuppression: false, autoGainControl: false };

export function can_listen() {
  return Boolean(navigator.mediaDevices?.getUserMedia && globalThis.AudioWorkletNode);
}

// Inputs there are; names come with the first permission.
export async function inputs() {
  if (!navigator.mediaDevices?.enumerateDevices) return [];
  const all = await navigator.mediaDevices.enumerateDevices();
  return all.filter(({ kind }) => kind === 'audioinput');
}

export class Microphone {
  // Opens it. All that takes time is done before: sound that comes while nobody listens is lost.
  static async open({ device, program, settings, desk, hear, gone }) {
    const audio = { ...PLAIN, channelCount: 1 };
    if (device) audio.deviceId = { exact: device };
    const stream = await navigator.mediaDevices.getUserMedia({ audio });
    try {
      return await new Microphone(stream).start({ program, settings, desk, hear, gone });
    } catch (why) {
      stream.getTracks().forEach((track) => track.stop());
      throw why;
    }
  }

  constructor(stream) {
    this.stream = stream;
    [this.track] = stream.getAudioTracks();
    this.about = this.track.getSettings();
  }

  async start({ program, settings, desk, hear, gone }) {
    // At the rate of the device nothing has to be converted on the way.
    const rate = this.about.sampleRate;
    this.context = new AudioContext({ latencyHint: 'interactive', ...(rate ? { sampleRate: rate } : {}) });
    await this.context.audioWorklet.addModule('worklet.js');
    const fs = this.context.sampleRate;
    this.name = this.track.label || 'microphone';
    const all = { ...settings, name: this.name, fs, full_scale: 1 };
    const { port1, port2 } = new MessageChannel();
    desk.postMessage({ program, settings: all, port: port1 }, [port1]);
    this.node = new AudioWorkletNode(this.context, 'ear', {
      numberOfInputs: 1,
      numberOfOutputs: 1,
      channelCount: 1,
      channelCountMode: 'explicit',
      processorOptions: { program, settings: new TextEncoder().encode(JSON.stringify(all)) },
    });
    this.node.port.postMessage({ desk: port2 }, [port2]);
    this.node.port.onmessage = ({ data }) => {
      if (data.measured === undefined) hear(data);
      else this.measured?.(data.measured);
    };
    this.node.onprocessorerror = () => gone(words_for.audio_thread);
    this.track.onended = () => gone(words_for.gone);
    this.context.onstatechange = () => {
      if (this.context.state === 'interrupted') hear({ paused: true });
    };
    this.source = this.context.createMediaStreamSource(this.stream);
    this.source.connect(this.node);
    // Silence: it only keeps the audio thread at work.
    this.node.connect(this.context.destination);
    await this.context.resume();
    return this;
  }

  // What the browser does to the sound all the same.
  interference() {
    return [
      [this.about.autoGainControl, 'automatic gain'],
      [this.about.noiseSuppression, 'noise suppression'],
      [this.about.echoCancellation, 'echo cancelling'],
    ].filter(([on]) => on).map(([, name]) => name);
  }

  tell_speed(speed) {
    this.node.port.postMessage({ speed });
  }

  // What so many blocks take in the audio thread, ms. The sound has a gap meanwhile.
  measure(blocks) {
    return new Promise((go) => {
      this.measured = go;
      this.node.port.postMessage({ measure: blocks });
    });
  }

  async stop() {
    this.node.port.postMessage({ stop: true });
    this.track.onended = null;
    this.track.stop();
    // The last of the sound is handed on by the audio thread, which ends with its context.
    await new Promise((go) => setTimeout(go, 150));
    await this.context.close();
  }
}
