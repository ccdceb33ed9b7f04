/* Embedded scenes follow the light and dark theme of the site, and are as high as their content. Pages from disk cannot
   access one another's documents, so messages contain the theme and the height. */
(() => {
  const root = document.documentElement;
  const frames = () => Array.from(document.querySelectorAll(".poinsot-view iframe"));
  const send = (frame) => frame.contentWindow.postMessage({ theme: root.dataset.theme }, "*");
  const sendAll = () => frames().forEach(send);
  new MutationObserver(sendAll).observe(root, { attributeFilter: ["data-theme"] });
  document.addEventListener("load", ({ target }) => frames().includes(target) && send(target), true);
  window.addEventListener("message", ({ source, data }) => {
    const frame = frames().find((each) => each.contentWindow === source);
    if (!frame || !Number.isFinite(data?.height)) return;
    const border = frame.offsetHeight - frame.clientHeight;
    frame.style.height = data.height > 0 ? `${data.height + border}px` : "";
  });
  sendAll();
})();
