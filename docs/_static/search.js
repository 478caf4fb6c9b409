/* Where no page has all words that were typed, show those with most of them; Sphinx would show none. */
document.addEventListener("DOMContentLoaded", () => {
  if (typeof Search === "undefined") return; // not the page of results
  const strict = Search.performTermsSearch;
  Search.performTermsSearch = (terms, excluded) => {
    const all = strict(terms, excluded);
    if (all.length || terms.size < 2) return all;
    const pages = new Map();
    for (const term of terms) {
      for (const result of strict(new Set([term]), excluded)) {
        const page = pages.get(result[0]) ?? { result, words: 0, score: 0 };
        page.words += 1;
        page.score += result[4];
        pages.set(result[0], page);
      }
    }
    const most = Math.max(...[...pages.values()].map((page) => page.words));
    return [...pages.values()].filter((page) => page.words === most).map(({ result, score }) => result.with(4, score));
  };
});

/* Opened as a file, a page may fetch no other: the excerpts come from one script with the words of all pages. */
if (location.protocol === "file:") {
  const root = document.documentElement.dataset.content_root ?? "./";
  let words;
  window.fetch = async (address) => {
    words ??= new Promise((done) => {
      const script = document.createElement("script");
      script.onload = script.onerror = () => done(window.EXCERPTS ?? {});
      script.src = `${root}_static/excerpts.js`;
      document.head.append(script);
    });
    const page = address.slice(root.length, -DOCUMENTATION_OPTIONS.FILE_SUFFIX.length);
    const main = document.createElement("div");
    main.setAttribute("role", "main");
    main.textContent = (await words)[page] ?? "";
    return { text: async () => main.outerHTML };
  };
}
