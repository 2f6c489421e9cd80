// How many pixels are drawn: few enough for 30 pictures a second while something moves, all of them when it stands.
const LEVELS = [1, 0.8, 0.62, 0.5, 0.4, 0.3]; // pixels of the picture per pixel of the page
const SLOW_ms = 1000 / 32;
const QUICK_ms = 1000 / 50;
const STILL_ms = 200;
const PATIENCE = { slower: 4, quicker: 90 }; // pictures in a row before a level is changed

// Whether the browser draws without a graphics card.
export function software() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const about = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = about ? String(gl.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class Quality {
  // `still()` is called when nothing has moved for a moment.
  constructor(soft, still) {
    Object.assign(this, { still, level: 0, slow: 0, quick: 0, before: -Infinity });
    const best = Math.min(2, window.devicePixelRatio * (soft ? 2 : 1)); // in place of smoothing by the card
    this.best = best;
    this.most = Math.min(best, soft ? 1 : window.devicePixelRatio);
  }

  // The ratio for a picture that is drawn at this time [ms].
  ratio(at) {
    const passed = at - this.before;
    this.before = at;
    clearTimeout(this.timer);
    if (passed > STILL_ms) return this.best;
    this.timer = setTimeout(() => {
      this.before = -Infinity;
      this.still();
    }, STILL_ms);
    this.slow = passed > SLOW_ms ? this.slow + 1 : 0;
    this.quick = passed < QUICK_ms ? this.quick + 1 : 0;
    if (this.slow >= PATIENCE.slower && this.level < LEVELS.length - 1) [this.level, this.slow] = [this.level + 1, 0];
    if (this.quick >= PATIENCE.quicker && this.level > 0) [this.level, this.quick] = [this.level - 1, 0];
    return this.most * LEVELS[this.level];
  }
}
