// The search index is fetched, which a browser does not allow from a disk: say so where the search would stand.
if (location.protocol === "file:") {
  const said = document.createElement("span");
  said.textContent = "search: python -m http.server";
  said.title = "The search works where the site is served, as by this command in its folder.";
  said.className = "md-header__source";
  said.style.fontSize = "0.65rem";
  document.querySelector(".md-header__inner").append(said);
}

// Words of code do not break at their hyphens: options of commands, and words in tables.
const unbroken = (selector, word) => {
  for (const code of document.querySelectorAll(selector)) {
    const texts = document.createTreeWalker(code, NodeFilter.SHOW_TEXT);
    const nodes = [];
    while (texts.nextNode()) nodes.push(texts.currentNode);
    for (const node of nodes) {
      node.replaceWith(...node.data.split(word).map((part, number) => {
        if (number % 2 === 0) return part;
        const span = document.createElement("span");
        span.className = "eai-word";
        span.textContent = part;
        return span;
      }));
    }
  }
};
unbroken(".language-console code, .language-sh code", /(--[\w-]+)/);
unbroken("td code, th code", /(?<!\S)(\S{1,60})(?!\S)/);
