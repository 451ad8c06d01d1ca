// The search index is fetched, which a browser does not allow from a disk: say so where the search would stand.
if (location.protocol === "file:") {
  const said = document.createElement("span");
  said.textContent = "search: python -m http.server";
  said.title = "The search works where the site is served, as by this command in its folder.";
  said.className = "md-header__source";
  said.style.fontSize = "0.65rem";
  document.querySelector(".md-header__inner").append(said);
}

// An option of a command is not broken at its hyphens.
for (const code of document.querySelectorAll(".language-console code, .language-sh code")) {
  code.innerHTML = code.innerHTML.replace(/--[\w-]+/g, '<span class="eai-option">$&</span>');
}
