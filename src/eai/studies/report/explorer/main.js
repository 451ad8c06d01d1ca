// Keys, buttons and the first picture.

function renderAll() {
  if (state.query.trim() && !textsAreRead) {
    texts ||= readTexts();
    texts.then(renderAll);
    return;
  }
  document.body.classList.toggle('pairing', Boolean(state.pair));
  const { kept, counts: found } = filterAnswers();
  const query = state.query.trim().toLowerCase();
  const matches = (pair) => !query || pair.left.text.includes(query) || pair.right.text.includes(query);
  state.shown = state.pair ? pairs().filter((pair) => inCell(pair, state.pair.cell) && matches(pair)) : kept;
  state.varying = state.pair ? [] : varyingIn(kept);
  if (state.selected && placeOfSelected() < 0) state.selected = null;
  if (!state.selected && state.shown.length) state.selected = state.shown[0].left || state.shown[0];
  renderFilters(found);
  renderPairChoice();
  renderSummary();
  renderList();
  renderDetail();
  writeAddress();
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
}

function toggleTheme() {
  const dark = document.documentElement.dataset.theme
    ? document.documentElement.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  setTheme(dark ? 'light' : 'dark');
}

function toggleFilters(open) {
  const now = document.body.classList.toggle('filtering', open);
  byId('open-filters').setAttribute('aria-expanded', String(now));
}

function escape() {
  if (document.activeElement === byId('search')) byId('search').blur();
  else if (document.body.classList.contains('filtering')) toggleFilters(false);
  else closeDetail();
}

const stepBy = (by) => {
  for (const box of document.querySelectorAll('.replay')) box.go(by);
};

const KEYS = {
  j: () => move(1), k: () => move(-1), n: () => stepBy(1), p: () => stepBy(-1), f: () => toggleFilters(),
  c: togglePair, t: toggleTheme, '?': () => byId('help').showModal(), '/': () => byId('search').focus(),
};

document.addEventListener('keydown', (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || byId('help').open) return;
  if (event.key === 'Escape') return escape();
  if (event.target.matches('input, select, textarea')) return;
  if (event.target === byId('list') && ['ArrowDown', 'ArrowUp'].includes(event.key)) {
    event.preventDefault();
    return move(event.key === 'ArrowDown' ? 1 : -1);
  }
  if (event.target === byId('list') && event.key === 'Enter' && state.selected) document.body.classList.add('reading');
  if (KEYS[event.key]) {
    event.preventDefault();
    KEYS[event.key]();
  }
});

byId('search').addEventListener('input', (event) => {
  state.query = event.target.value;
  renderAll();
});
byId('list').addEventListener('scroll', renderList, { passive: true });
byId('theme').addEventListener('click', toggleTheme);
byId('open-help').addEventListener('click', () => byId('help').showModal());
byId('open-filters').addEventListener('click', () => toggleFilters());
byId('open-pair').addEventListener('click', togglePair);
byId('open-pair').hidden = !runs.some((run) => rivalsOf(run).length);
window.addEventListener('resize', renderList);
window.addEventListener('hashchange', start);

function start() {
  readAddress();
  byId('search').value = state.query;
  if (state.selected && location.hash.includes('task=')) document.body.classList.add('reading');
  renderAll();
  const place = placeOfSelected();
  if (place >= 0) bringIntoSight(place);
  renderList();
}
start();
