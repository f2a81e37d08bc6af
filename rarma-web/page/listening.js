// One listening: its worker, and its place in the list of what was heard.

import { words_for } from './words.js';

// What the report calls bad, careful, good and unknown: the state it is drawn as.
export const STATES = { bad: 'chatter', careful: 'warning', good: 'stable', unknown: 'invalid' };

export class Listening {
  // `show` gets what the worker says; `list` is where it stands afterwards.
  constructor({ name, list, show }) {
    this.name = name;
    this.show = show;
    this.saved = false;
    this.live = false;
    this.waiting = new Map();
    this.number = 0;
    this.worker = new Worker('desk.js', { type: 'module' });
    this.worker.onmessage = ({ data }) => this.said(data);
    this.worker.onerror = (event) => this.show(this, { refused: words_for.worker(event.message) });
    this.item = document.createElement('li');
    list.prepend(this.item);
    this.entry('listening …');
  }

  said(data) {
    if (data.answer !== undefined) {
      this.waiting.get(data.answer)?.(data);
      this.waiting.delete(data.answer);
      return;
    }
    if (data.heard) this.last = data.heard;
    if (data.ended) {
      this.summary = data.ended;
      this.item.dataset.state = STATES[data.headline.tone];
      this.entry(`${data.headline.text}.`, true);
    }
    this.show(this, data);
  }

  ask(want) {
    this.number += 1;
    const { number } = this;
    return new Promise((go) => {
      this.waiting.set(number, go);
      this.worker.postMessage({ want, number });
    });
  }

  // What stands in the list.
  entry(text, whole = false) {
    const title = document.createElement('b');
    title.textContent = this.name;
    const words = document.createElement('div');
    words.textContent = text;
    const row = document.createElement('div');
    row.className = 'row';
    const button = (label, act) => {
      const made = document.createElement('button');
      made.type = 'button';
      made.textContent = label;
      made.setAttribute('aria-label', `${label}: ${this.name}`);
      made.onclick = act;
      row.append(made);
    };
    button('Save report', () => this.save('report'));
    if (this.live) button('Save sound', () => this.save('sound'));
    if (whole) button('Forget', () => this.forget());
    this.item.replaceChildren(title, words, row);
  }

  async save(want) {
    const { blob } = await this.ask(want);
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    const stem = `rarma ${this.name}`.replace(/[^\p{L}\p{N}._ -]+/gu, '_').replace(/\.[^.]{1,5}$/, '');
    const date = new Date().toISOString().slice(0, 19).replaceAll(':', '');
    link.download = `${stem} ${date}.${want === 'report' ? 'html' : 'wav'}`;
    link.click();
    if (want === 'sound') this.saved = true;
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  }

  forget() {
    this.worker.terminate();
    this.item.remove();
    this.saved = true;
    this.show(this, { forgotten: true });
  }
}
