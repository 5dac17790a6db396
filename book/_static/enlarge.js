// A click on a figure shows it as large as the window allows; another click, or Escape, closes it.
document.addEventListener("DOMContentLoaded", () => {
  const figures = document.querySelectorAll("article.bd-article figure img, div.cell_output img");
  if (!figures.length) return;
  const dialog = document.createElement("dialog");
  dialog.className = "enlarged";
  dialog.setAttribute("aria-label", "Enlarged figure");
  const picture = document.createElement("img");
  dialog.append(picture);
  dialog.addEventListener("click", () => dialog.close());
  // The theme takes Escape for its search box.
  window.addEventListener("keydown", (e) => e.key === "Escape" && dialog.close(), true);
  document.body.append(dialog);
  for (const figure of figures) {
    if (figure.closest("a")) continue;
    const open = () => {
      picture.src = figure.src;
      picture.alt = figure.alt;
      // A narrow window shows the picture in its own size and scrolls it.
      picture.style.minWidth = `${Math.min(figure.naturalWidth, 1000)}px`;
      dialog.showModal();
    };
    const button = document.createElement("button");
    button.className = "enlarge";
    button.title = "Enlarge the figure";
    button.setAttribute("aria-label", "Enlarge the figure");
    button.textContent = "⤢";
    button.addEventListener("click", open);
    figure.addEventListener("click", open);
    figure.after(button);
  }
});
