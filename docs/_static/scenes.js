/* Embedded scenes follow the light and dark theme of the site. Pages from disk cannot access one another's documents, so
   a message contains the theme. */
(() => {
  const root = document.documentElement;
  const send = (frame) => frame.contentWindow.postMessage({ theme: root.dataset.theme }, "*");
  const sendAll = () => document.querySelectorAll("iframe").forEach(send);
  new MutationObserver(sendAll).observe(root, { attributeFilter: ["data-theme"] });
  document.addEventListener("load", ({ target }) => target.tagName === "IFRAME" && send(target), true);
  sendAll();
})();
