// Match sounds, off until the user presses the button. The browser synthesizes them; nothing is loaded.
import { make } from "./dom.js";

const CUES = {  // notes: frequency [Hz], start [s], duration [s]
  start: [[523, 0, 0.15], [659, 0.15, 0.15], [784, 0.3, 0.45]],
  stop: [[330, 0, 0.5]],
  change: [[880, 0, 0.12], [880, 0.2, 0.12]],
  last: [[988, 0, 0.12], [988, 0.18, 0.12], [988, 0.36, 0.3]],
  end: [[294, 0, 1.2], [220, 0, 1.2]],
  scored: [[1175, 0, 0.07]],
  count: [[587, 0, 0.12]],
};
const LAST = 30.5;  // [s] before the end of the match; a period that begins later is the last period
const JUMP = 2;  // [s]; a larger step in time is a jump, without a sound

/** Return the name of the sound for a change of the match clock, or null for no sound. */
export function cueOf(was, is) {
  if (is.enabled && is.time < 1 && (!was || !was.enabled || is.time < was.time)) return "start";
  if (!was || Math.abs(is.time - was.time) > JUMP) return null;
  if (is.enabled !== was.enabled) return is.enabled ? "start" : is.left < 0.2 ? "end" : "stop";
  if (!is.enabled || is.period === was.period) return null;
  return is.left < LAST ? "last" : "change";
}

export class Sounds {
  constructor() {
    this.context = null;
    this.before = null;
    this.button = make("button", { type: "button", "aria-pressed": "false", onclick: () => this.turn(!this.isOn) }, "sound: off");
    this.isOn = false;
  }

  turn(on) {
    this.context ??= new AudioContext();  // allowed by browsers only after a user action
    this.isOn = on;
    this.button.textContent = on ? "sound: on" : "sound: off";
    this.button.setAttribute("aria-pressed", String(on));
    this.button.blur();
  }

  /** Turn the sound on for a driver, unless the driver has used the sound button. */
  first() { if (!this.context) this.turn(true); }

  /** Play the sound for a new state of the match clock: period, enabled, time since the start [s] and time left [s]. */
  see(clock) {
    const cue = cueOf(this.before, clock);
    this.before = clock;
    if (cue) this.play(cue);
  }

  play(cue) {
    if (!this.isOn) return;
    for (const [frequency, when, length] of CUES[cue]) {
      const start = this.context.currentTime + when, tone = this.context.createOscillator(), loudness = this.context.createGain();
      tone.frequency.value = frequency;
      loudness.gain.setValueAtTime(0.15, start);
      loudness.gain.linearRampToValueAtTime(0, start + length);
      tone.connect(loudness).connect(this.context.destination);
      tone.start(start);
      tone.stop(start + length);
    }
  }
}
