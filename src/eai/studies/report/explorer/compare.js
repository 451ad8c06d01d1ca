// Two runs: the tasks on which they differ.

const CELLS = [['differ', 'outcome differs'], ['both', 'both succeed'], ['a', 'only the first'], ['b', 'only the second'],
  ['neither', 'neither'], ['all', 'all']];

const pairs = () => state.pair.a.answers
  .map((left) => ({ task: left.task, left, right: answerOf(state.pair.b, left.task) })).filter((pair) => pair.right);

function inCell(pair, cell) {
  const [one, other] = [pair.left.outcome === SUCCESS, pair.right.outcome === SUCCESS];
  switch (cell) {
    case 'differ': return pair.left.outcome !== pair.right.outcome;
    case 'both': return one && other;
    case 'a': return one && !other;
    case 'b': return other && !one;
    case 'neither': return !one && !other;
    default: return true;
  }
}

function pairRow(pair) {
  return [element('span', { class: 'swatches' }, swatch(pair.left.outcome), swatch(pair.right.outcome)),
    nameOf(pair.left),
    element('span', { class: 'why' }, `${words(pair.left.outcome)} → ${words(pair.right.outcome)}`)];
}

function renderPairSummary() {
  const everything = pairs();
  show('summary', element('div', { class: 'cells' }, CELLS.map(([cell, label]) => element('button', {
    type: 'button', class: 'cell', 'aria-pressed': String(state.pair.cell === cell),
    onclick: () => { state.pair.cell = cell; renderAll(); },
  }, element('strong', {}, String(everything.filter((pair) => inCell(pair, cell)).length)), label))));
}

function renderPairChoice() {
  const box = byId('pair');
  box.hidden = !state.pair;
  byId('open-pair').setAttribute('aria-pressed', String(Boolean(state.pair)));
  if (!state.pair) return;
  const choose = (label, name, among, run, pick) => element('label', {}, element('span', {}, label),
    element('select', { 'data-run': name, onchange: (event) => pick(runs[Number(event.target.value)]) },
      among.map((choice) => element('option', { value: choice.number, selected: choice === run },
        [choice.model, choice.protocol, words(choice.ability), title(choice.domain)].join(' · ')))));
  const rivals = rivalsOf(state.pair.a);
  box.replaceChildren(
    choose('First', 'a', runs.filter((run) => rivalsOf(run).length), state.pair.a, (run) => comparePair(run, rivalsOf(run)[0], null)),
    choose('Second', 'b', rivals, state.pair.b, (run) => comparePair(state.pair.a, run, null)));
}

const rivalsOf = (run) => runs.filter((other) => other !== run && other.suite === run.suite);

function comparePair(a, b, task) {
  state.pair = { a, b, cell: task ? 'all' : 'differ' };
  state.selected = task ? answerOf(a, task) : null;
  state.step = null;
  renderAll();
  const place = placeOfSelected();
  if (place >= 0) bringIntoSight(place);
  renderList();
}

function togglePair() {
  if (state.pair) {
    state.pair = null;
    renderAll();
    return;
  }
  const candidates = state.selected ? [state.selected.run, ...runs] : runs;
  const first = candidates.find((run) => rivalsOf(run).length);
  if (first) comparePair(first, rivalsOf(first)[0], null);
}
