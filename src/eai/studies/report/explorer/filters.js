// Faceted filtering: each facet counts what its options would give, the other facets being as they are.

function filterAnswers() {
  const query = state.query.trim().toLowerCase();
  const active = FACETS.filter((facet) => state.chosen[facet.key].size);
  const counts = Object.fromEntries(FACETS.map((facet) => [facet.key, new Map()]));
  const kept = [];
  for (const answer of answers) {
    if (query && !answer.text.includes(query)) continue;
    const failing = active.filter((facet) => !facet.of(answer).some((value) => state.chosen[facet.key].has(value)));
    if (failing.length > 1) continue;
    if (!failing.length) kept.push(answer);
    for (const facet of failing.length ? failing : FACETS) {
      for (const value of facet.of(answer)) {
        counts[facet.key].set(value, (counts[facet.key].get(value) || 0) + 1);
      }
    }
  }
  return { kept, counts };
}

const everyValue = FACETS.map((facet) => {
  const found = new Set();
  for (const answer of answers) for (const value of facet.of(answer)) found.add(value);
  const values = [...found];
  const place = (value) => (facet.order ? facet.order.indexOf(value) : 0);
  return values.sort((one, other) => place(one) - place(other) || one.localeCompare(other));
});

function renderFilters(counts) {
  const most = Math.max(1, ...FACETS.flatMap((facet) => [...counts[facet.key].values()]));
  const facets = FACETS.map((facet, index) => {
    const values = everyValue[index];
    if (values.length < 2) return null;
    return element('fieldset', { class: 'facet' }, element('legend', {}, facet.title),
      values.map((value) => option(facet, value, counts[facet.key].get(value) || 0, most)));
  });
  const any = FACETS.some((facet) => state.chosen[facet.key].size) || state.query;
  const clear = element('button', { type: 'button', class: 'quiet', onclick: clearFilters, disabled: !any }, 'Clear all filters');
  show('filters', facets, clear);
}

function option(facet, value, count, most) {
  const chosen = state.chosen[facet.key].has(value);
  const bar = element('span', { class: 'share', 'aria-hidden': 'true' });
  bar.style.width = `${(100 * count) / most}%`;
  return element('button', {
    type: 'button', class: count ? 'option' : 'option none', 'aria-pressed': String(chosen),
    'data-facet': facet.key, 'data-value': value, onclick: () => toggle(facet.key, value),
  }, bar, facet.colored && swatch(value), element('span', { class: 'label' }, facet.plain ? value : title(value)),
  element('span', { class: 'count' }, count.toLocaleString('en')));
}

function toggle(key, value) {
  const values = state.chosen[key];
  if (!values.delete(value)) values.add(value);
  renderAll();
  const again = [...document.querySelectorAll('.option')].find(
    (button) => button.dataset.facet === key && button.dataset.value === value);
  if (again) again.focus();
}

function clearFilters() {
  for (const values of Object.values(state.chosen)) values.clear();
  state.query = '';
  byId('search').value = '';
  renderAll();
}
