/* Pages from disk may not fetch one another: the summaries of the search are taken from texts.js instead. */
if (location.protocol === "file:" && DOCUMENTATION_OPTIONS.pagename === "search")
  window.fetch = async (url) => ({ text: async () => TEXTS[decodeURI(url).replace(/^(\.\/)*|\.html.*$/g, "")] ?? "" });
