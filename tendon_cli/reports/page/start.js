// Starts all parts in order, marks the page as ready, and draws it again when the colours change.

async function start() {
  await startMap();
  await startStates();
  await startAnswers();
  await startTable();
  document.documentElement.dataset.ready = "yes";
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  for (const again of redraws.values()) {
    again();
  }
  if (page.states) {
    drawArm();
  }
});

start().catch(showFault);
