// The page's sound button; what it sounds for is on the score board.
(() => {
  matchSounds.button.style.cssText = "position:fixed;left:12px;bottom:96px;z-index:1000;font:14px/1.4 system-ui," +
    "sans-serif;padding:6px 14px;border:0;border-radius:6px;background:#4a5260;color:#fff";
  document.body.append(matchSounds.button);
  setInterval(() => {
    const clock = document.querySelector(".simcore-clock");
    if (!clock || clock.dataset.period === undefined) return;
    const { period, enabled, time, left } = clock.dataset;
    matchSounds.see({ period, enabled: enabled === "True", time: Number(time), left: Number(left) });
  }, 50);
})();
