"use strict";
(() => {
  const bad = new Set(["fail", "error", "timeout", "crash", "xpass"]);
  const get = (id) => document.getElementById(id);
  const form = get("filters");
  // Each number of the verdicts shows the vectors that it counts; again, and all are there.
  const counts = [...document.querySelectorAll(".count")];
  const rows = [...document.querySelectorAll(".matrix tbody tr")].map((row) => ({
    row,
    tier: row.dataset.tier,
    tools: row.dataset.tools.split(" "),
    rules: row.dataset.rules.split(" "),
    statuses: row.dataset.statuses.trim().split(" "),
    text: row.dataset.text,
  }));

  function filter() {
    const words = get("f-text").value.toLowerCase().split(/\s+/).filter(Boolean);
    const adapter = get("f-adapter").value;
    const status = get("f-status").value;
    const [tier, tool, rule] = ["f-tier", "f-tool", "f-rule"].map((id) => get(id).value);
    let shown = 0;
    for (const one of rows) {
      const statuses = adapter === "" ? one.statuses : [one.statuses[Number(adapter)]];
      const fits =
        words.every((word) => one.text.includes(word)) &&
        (status === "" ? adapter === "" || statuses[0] !== "-"
          : statuses.some((s) => (status === "bad" ? bad.has(s) : s === status))) &&
        (tier === "" || one.tier === tier) &&
        (tool === "" || one.tools.includes(tool)) &&
        (rule === "" || one.rules.includes(rule));
      one.row.hidden = !fits;
      shown += fits;
    }
    for (const count of counts) {
      count.setAttribute("aria-pressed", count.dataset.adapter === adapter && count.dataset.status === status);
    }
    get("f-count").value = `${shown} of ${rows.length} vectors`;
  }

  for (const count of counts) {
    count.disabled = false;
    count.addEventListener("click", () => {
      const pressed = count.getAttribute("aria-pressed") === "true";
      form.reset();
      if (!pressed) {
        get("f-adapter").value = count.dataset.adapter;
        get("f-status").value = count.dataset.status;
      }
      filter();
    });
  }
  form.hidden = false;
  form.addEventListener("input", filter);
  form.addEventListener("change", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", () => setTimeout(filter));
  filter();

  // The place to come back to, and the one that a reader of the screen is told.
  let scrolled = 0;
  document.addEventListener("click", (event) => {
    if (event.target.closest(".matrix a")) scrolled = window.scrollY;
  });
  window.addEventListener("hashchange", () => {
    const page = location.hash.length > 1 ? get(location.hash.slice(1)) : null;
    if (page && page.classList.contains("failure")) {
      page.focus({ preventScroll: true });
      window.scrollTo(0, 0);
    } else {
      window.scrollTo(0, scrolled);
    }
  });
})();
