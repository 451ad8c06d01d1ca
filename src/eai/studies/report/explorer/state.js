// What is shown, and its twin in the address.

const FACETS = [
  { key: 'domain', title: 'Domain', of: (answer) => [answer.run.domain] },
  { key: 'ability', title: 'Ability', of: (answer) => [answer.run.ability] },
  { key: 'model', title: 'Model', of: (answer) => [answer.run.model], plain: true },
  { key: 'protocol', title: 'Protocol', of: (answer) => [answer.run.protocol], plain: true },
  { key: 'outcome', title: 'Outcome', of: (answer) => [answer.outcome], order: OUTCOMES, colored: true },
  { key: 'error', title: 'Error', of: errorsIn },
  { key: 'category', title: 'Category', of: (answer) => [...(answer.row.k || []), ...(answer.row.c ? [answer.row.c] : [])] },
  { key: 'planner', title: 'Planner', of: (answer) => (answer.row.p ? [answer.row.p] : []) },
  { key: 'repair', title: 'Repairs', of: (answer) => answer.row.m || [] },
];

function errorsIn(answer) {
  const found = [];
  if (answer.row.f) found.push(answer.row.f[0]);
  if (answer.row.a) found.push('additional_step');
  if (answer.row.h) found.push('hallucination');
  return [...new Set(found)];
}

const state = {
  query: '',
  chosen: Object.fromEntries(FACETS.map((facet) => [facet.key, new Set()])),
  selected: null,   // an answer
  step: null,       // a step of its plan, from 0; null is the end, -1 the start
  pair: null,       // {a, b, cell}: two runs, and which of the four fields of their table
  shown: [],        // the answers, or pairs of answers, in the list
  varying: [],      // in what the answers in the list differ
};

function writeAddress() {
  const parts = new URLSearchParams();
  if (state.query) parts.set('q', state.query);
  for (const [key, values] of Object.entries(state.chosen)) {
    for (const value of values) parts.append(key, value);
  }
  if (state.pair) {
    parts.set('a', state.pair.a.key);
    parts.set('b', state.pair.b.key);
    if (state.pair.cell !== 'differ') parts.set('cell', state.pair.cell);
  }
  if (state.selected) {
    if (!state.pair) parts.set('run', state.selected.run.key);
    parts.set('task', state.selected.task);
    if (state.step !== null) parts.set('step', String(state.step + 1));
  }
  const hash = `#${parts}`;
  if (hash !== location.hash && !(hash === '#' && !location.hash)) history.replaceState(null, '', hash);
}

function readAddress() {
  const parts = new URLSearchParams(location.hash.slice(1));
  const runOf = (key) => runs.find((run) => run.key === key) || null;
  state.query = parts.get('q') || '';
  for (const facet of FACETS) state.chosen[facet.key] = new Set(parts.getAll(facet.key));
  const [a, b] = [runOf(parts.get('a')), runOf(parts.get('b'))];
  state.pair = a && b && a.suite === b.suite ? { a, b, cell: parts.get('cell') || 'differ' } : null;
  const run = state.pair ? state.pair.a : runOf(parts.get('run'));
  state.selected = (run && answerOf(run, parts.get('task'))) || null;
  const step = Number.parseInt(parts.get('step'), 10);
  state.step = state.selected && step >= 0 ? step - 1 : null;
}
