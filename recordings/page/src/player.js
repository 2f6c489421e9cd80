// The time that all parts of the page share: jump to it, play it at a speed, follow the newest of a run that goes on.
export class Player {
  constructor(run, show) {
    Object.assign(this, { run, show, now: run.first, playing: false, following: false, speed: 20, onchange: () => {} });
  }

  jump(t) {
    this.following = this.following && t >= this.run.last;
    this.now = Math.min(this.run.last, Math.max(this.run.first, t));
    this.show(this.now);
  }

  follow(on) {
    this.following = on;
    if (on) {
      this.play(false);
      this.now = this.run.last;
      this.show(this.now);
    }
    this.onchange();
  }

  play(on) {
    this.playing = on;
    if (on) this.following = false;
    if (on && this.now >= this.run.last) this.jump(this.run.first);
    this.before = undefined;
    if (on) requestAnimationFrame((at) => this.tick(at));
    this.onchange();
  }

  tick(at) {
    if (!this.playing) return;
    const passed = Math.max(0, at - (this.before ?? at)) / 1e3;
    this.before = at;
    this.jump(this.now + passed * this.speed);
    if (this.now >= this.run.last) this.play(false);
    else requestAnimationFrame((next) => this.tick(next));
  }
}
