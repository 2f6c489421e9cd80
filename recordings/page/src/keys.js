// The keyboard: every key of the page, and the overlay that lists them.
const VIEWS = ["corner", "along", "across", "top"];

export function keyboard({ run, player, stage, events, speed, toggle, save, help, follow }) {
  const step = () => Math.max(0.1, player.speed / 4);
  const to = (t) => t !== undefined && player.jump(t);
  const faster = (by) => {
    speed.selectedIndex = Math.min(speed.options.length - 1, Math.max(0, speed.selectedIndex + by));
    speed.onchange();
  };
  const stageAt = (way) => {
    const times = run.stages.map((s) => s.t);
    return way > 0 ? times.find((t) => t > player.now + 1e-6) : times.findLast((t) => t < player.now - 1e-6);
  };
  const keys = {
    " ": () => player.play(!player.playing),
    ArrowRight: () => player.jump(player.now + step()),
    ArrowLeft: () => player.jump(player.now - step()),
    Home: () => player.jump(run.first),
    End: () => player.jump(run.last),
    n: () => to(events.next(player.now, 1)),
    b: () => to(events.next(player.now, -1)),
    PageDown: () => to(stageAt(1)),
    PageUp: () => to(stageAt(-1)),
    "+": () => faster(1),
    "-": () => faster(-1),
    l: () => player.follow(!player.following),
    d: toggle,
    p: () => print(),
    s: save,
    f: () => follow.click(),
    "?": () => (help.open ? help.close() : help.showModal()),
  };
  VIEWS.forEach((view, i) => (keys[i + 1] = () => stage.look(view)));
  addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.matches("input[type=checkbox], select")) return;
    if (help.open && e.key !== "?") return;
    const act = keys[e.key];
    if (act) {
      e.preventDefault();
      act();
    }
  });
}
