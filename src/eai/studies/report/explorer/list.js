// The list: thousands of rows, of which only those in sight are in the page.

const ROW = 56;

function renderSummary() {
  if (state.pair) return renderPairSummary();
  const parts = countOutcomes(state.shown);
  const right = parts.find((part) => part.outcome === 'success');
  const scored = state.shown.length - (parts.find((part) => part.outcome === 'excluded') || { count: 0 }).count;
  const share = SUCCESS !== 'success' ? 'outcomes in logs of other projects' : scored ? `${Math.round((100 * (right ? right.count : 0)) / scored)} % success` : '';
  return show('summary', element('p', { class: 'tally', role: 'status' },
    element('strong', {}, plural(state.shown.length, 'answer')), share && ` · ${share}`),
  state.shown.length ? stack(parts) : null);
}

function renderList() {
  const rows = byId('rows');
  rows.style.height = `${state.shown.length * ROW}px`;
  if (!state.shown.length) {
    rows.replaceChildren(element('p', { class: 'empty' }, 'No answer is like that. Fewer filters show more.'));
    rows.style.height = 'auto';
    return;
  }
  const list = byId('list');
  const first = Math.max(0, Math.floor(list.scrollTop / ROW) - 6);
  const last = Math.min(state.shown.length, Math.ceil((list.scrollTop + list.clientHeight) / ROW) + 6);
  const place = placeOfSelected();
  if (place >= 0) list.setAttribute('aria-activedescendant', `row-${place}`);
  else list.removeAttribute('aria-activedescendant');
  const made = [];
  for (let index = first; index < last; index += 1) made.push(rowAt(index, index === place));
  rows.replaceChildren(...made);
}

function rowAt(index, selected) {
  const item = state.shown[index];
  const row = element('div', {
    class: 'row', role: 'option', id: `row-${index}`, 'aria-selected': String(selected),
    'aria-setsize': state.shown.length, 'aria-posinset': index + 1, onclick: () => select(index, true),
  }, item.left ? pairRow(item) : answerRow(item));
  row.style.transform = `translateY(${index * ROW}px)`;
  return row;
}

function answerRow(answer) {
  const error = errorOf(answer);
  const where = state.varying.map((key) => (key === 'model' || key === 'protocol' ? answer.run[key] : title(answer.run[key])));
  return [swatch(answer.outcome), nameOf(answer),
    element('span', { class: 'what' }, words(answer.outcome)),
    element('span', { class: 'why' }, [...where, where.length < 2 ? reasonOf(answer, error) : ''].filter(Boolean).join(' · '))];
}

// Why an answer is no success, in a few words.
function reasonOf(answer, error) {
  if (answer.row.z) return ['cut off', error && error.detail].filter(Boolean).join(' · ');
  if (error) return error.detail;
  const [right, wrong, missed] = answer.row.N || [];
  return answer.row.N ? `${right} right, ${wrong} wrong, ${missed} missed` : '';
}

// The name of an answer's task, and its id where other tasks have that name too: some ids end in a scene and a date,
// which tell nobody anything.
function nameOf(answer) {
  const { name } = taskOf(answer);
  const tells = name !== answer.task && !answer.task.startsWith(name.replace(/ /g, '_'));
  return element('span', { class: 'task' }, element('span', { class: 'called' }, name), tells ? element('span', { class: 'id' }, answer.task) : null);
}

// What tells the answers in the list apart, besides their tasks.
const varyingIn = (shown) => ['model', 'protocol', 'ability', 'domain'].filter(
  (key) => shown.some((answer) => answer.run[key] !== shown[0].run[key]));

const sameItem = (item) => (item.left || item) === state.selected;
const placeOfSelected = () => (state.selected ? state.shown.findIndex(sameItem) : -1);

function select(index, open) {
  const item = state.shown[index];
  if (!item) return;
  state.selected = item.left || item;
  state.step = null;
  if (open) document.body.classList.add('reading');
  bringIntoSight(index);
  renderList();
  renderDetail();
  writeAddress();
}

function move(by) {
  const place = placeOfSelected();
  const next = place < 0 ? 0 : Math.min(state.shown.length - 1, Math.max(0, place + by));
  select(next, false);
}

function bringIntoSight(index) {
  const list = byId('list');
  if (index * ROW < list.scrollTop) list.scrollTop = index * ROW;
  const below = (index + 1) * ROW - list.clientHeight;
  if (below > list.scrollTop) list.scrollTop = below;
}
