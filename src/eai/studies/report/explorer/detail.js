// One answer, or the answers of two runs to one task, side by side.

function renderDetail() {
  const place = byId('detail');
  const other = state.pair && state.selected && answerOf(state.pair.b, state.selected.task);
  const unread = [state.selected, other].filter((answer) => answer && !answer.chunk.isRead);
  place.setAttribute('aria-busy', String(unread.length > 0));
  place.scrollTop = 0;
  if (!state.selected) {
    place.replaceChildren(element('p', { class: 'empty welcome' }, 'Choose an answer. ',
      element('kbd', {}, 'j'), ' and ', element('kbd', {}, 'k'), ' go through the list.'));
    return;
  }
  const back = element('button', { type: 'button', class: 'back', onclick: closeDetail }, '← Answers');
  if (unread.length) {
    fill(place, back, heading(state.selected));
    Promise.all(unread.map(read)).then(() => place.getAttribute('aria-busy') === 'true' && renderDetail());
    return;
  }
  if (state.pair) {
    fill(place, back, heading(state.selected),
      element('div', { class: 'columns even two' }, [state.selected, other].map((answer) => element('div', { class: 'side-run' },
        element('h3', { class: 'run-name' }, answer.run.model, element('span', {}, answer.run.protocol)), body(answer, true)))),
      promptBlock(state.selected));
    return;
  }
  fill(place, back, heading(state.selected), body(state.selected, false), promptBlock(state.selected), others(state.selected));
}

function closeDetail() {
  document.body.classList.remove('reading');
  byId('list').focus();
}

function heading(answer) {
  const { run } = answer;
  const task = taskOf(answer);
  const parts = [title(run.domain), words(run.ability), ...(state.pair ? [] : [run.model, `protocol ${run.protocol}`])];
  return element('header', { class: 'heading' }, element('h2', {}, task.name),
    element('p', { class: 'where' }, parts.join(' · ')),
    task.name === answer.task ? null : element('p', { class: 'id' }, answer.task),
    task.instruction ? element('p', { class: 'instruction' }, task.instruction) : null);
}

function body(answer, narrow) {
  return element('div', { class: narrow ? 'body narrow' : 'body' }, verdict(answer), attempts(answer), goals(answer), counts(answer),
    operators(answer), replay(answer), filmLink(answer), notes(answer), rawAnswer(answer), logLink(answer));
}

function verdict(answer) {
  const error = errorOf(answer);
  const { row } = answer;
  const lines = [];
  if (row.z) lines.push('The answer was cut off at a length limit.');
  if (row.x !== undefined) lines.push(`Left out of all rates: ${row.x}.`);
  if (row.u !== undefined) lines.push(`There is no answer: ${row.u}.`);
  if (error) lines.push(`${title(error.kind)}${stepText(answer, error)}: ${error.detail}`);
  if (error && answer.outcome === 'success') lines.push('The goals hold all the same.');
  lines.push(...row.R || []);
  if (row.a) lines.push(`${plural(row.a, 'step')} skipped as not needed.`);
  const ran = isActing(answer) ? ['no impossible action', 'impossible actions'] : ['executable', 'not executable'];
  const tags = [row.e !== undefined && ran[row.e ? 0 : 1], row.c && words(row.c),
    row.p && `planner: ${words(row.p)}`, ...(row.m || []).map((repair) => `repaired: ${words(repair)}`)].filter(Boolean);
  return element('div', { class: `verdict-box of-${answer.outcome}` },
    element('p', { class: 'headline' }, words(answer.outcome).replace(/^./, (first) => first.toUpperCase())),
    lines.map((line) => element('p', {}, line)),
    tags.length ? element('p', { class: 'tags' }, tags.map((tag) => element('span', { class: 'tag' }, tag))) : null);
}

// Attempts at a task side by side: what each said, and what in it the one before did not say.
function attempts(answer) {
  const found = attemptsOf(answer);
  if (!found.length) return null;
  return element('section', { class: 'attempts' }, element('h3', {}, 'Attempts'),
    element('p', { class: 'empty' }, 'In bold: steps that the attempt before did not have.'),
    element('div', { class: 'columns even' }, found.map((attempt, number) => attemptColumn(attempt, found[number - 1], number))));
}

function attemptColumn(attempt, before, number) {
  const known = before ? stepsOf(before).map((step) => step.action) : [];
  const isNew = (step) => {
    const place = known.indexOf(step.action);
    if (place >= 0) known.splice(place, 1);
    return before && place < 0;
  };
  const steps = stepsOf(attempt);
  return element('div', { class: 'attempt' }, element('h4', {}, `Attempt ${number + 1} `, badge(attempt.outcome)),
    steps.length ? element('ol', {}, steps.map((step) => element('li', { class: isNew(step) ? 'new' : null },
      element('code', {}, step.action),
      step.outcome === 'executed' ? null : element('span', { class: 'kind' }, `${words(step.outcome)}: ${step.reason}`)))) : rawAnswer(attempt));
}

const stepText = (answer, error) => {
  if (error.step === null) return '';
  const noun = answer.run.ability === 'subgoal_decomposition' ? 'subgoal' : 'step';
  return ` at ${noun} ${error.step + 1}`;
};

// How an explanation of goals begins a note on a goal that the task does not have.
const WRONG = 'wrong: ';

function goals(answer) {
  const found = goalsOf(answer);
  const invented = notesOf(answer).filter((note) => note.startsWith(WRONG)).map((note) => note.slice(WRONG.length));
  const hallucinated = [...new Set(answer.row.h || [])];
  const interpretation = answer.run.ability === 'goal_interpretation';
  if (!found.length && !invented.length && !hallucinated.length) return null;
  const met = found.filter((goal) => goal.satisfied);
  const missed = found.filter((goal) => !goal.satisfied);
  const list = (heading, items, mark) => element('div', { class: `goal-list ${mark}` },
    element('h4', {}, `${heading} `, element('span', { class: 'count' }, items.length)),
    items.length ? element('ul', {}, items.map((item) => element('li', {}, element('code', {}, item.goal || item),
      item.kind && element('span', { class: 'kind' }, item.kind),
      (item.remarks || []).map((remark) => element('div', { class: 'reason' }, remark))))) : element('p', { class: 'empty' }, 'none'));
  return element('section', { class: 'goals' }, element('h3', {}, interpretation ? 'Goals' : `Goals at the end${conditions(answer)}`),
    element('div', { class: 'columns even' }, list(interpretation ? 'Found' : 'Reached', met, 'met'), list('Missed', missed, 'missed'),
      invented.length ? list('Invented', invented, 'invented') : null,
      hallucinated.length ? list('Names that do not exist', hallucinated, 'invented') : null));
}

function conditions(answer) {
  if (!answer.row.C) return '';
  const [met, total] = answer.row.C;
  return `: ${met} of ${plural(total, 'condition')} met`;
}

function counts(answer) {
  const rows = Object.entries(answer.row.n || {}).filter(([, row]) => row.some(Boolean));
  if (!rows.length) return null;
  return element('table', { class: 'counts' }, element('caption', {}, 'Counts'),
    element('thead', {}, element('tr', {}, ['', 'right', 'wrong', 'missed'].map((head) => element('th', { scope: 'col' }, head)))),
    element('tbody', {}, rows.map(([name, row]) => element('tr', {}, element('th', { scope: 'row' }, words(name.replace('/', ': '))),
      row.map((count) => element('td', {}, String(count)))))));
}

function notes(answer) {
  const found = notesOf(answer).filter((note) => !note.startsWith(WRONG));
  if (!found.length || answer.run.ability === 'transition_modeling') return null;
  return element('section', { class: 'notes' }, element('h3', {}, 'How it was read'),
    element('ul', {}, found.map((note) => element('li', {}, note))));
}

// Where Inspect's viewer shows the sample, once it runs on its usual port.
function logLink(answer) {
  if (!answer.run.log) return null;
  const [files, epochs, viewer] = answer.run.log;
  const file = typeof files === 'string' ? files : files[answer.task];
  const epoch = typeof epochs === 'number' ? epochs : epochs[answer.task];
  if (!file) return null;
  const address = `${viewer}/${encodeURIComponent(file)}/samples/sample/${encodeURIComponent(answer.task)}/${epoch}/`;
  return element('p', { class: 'log' }, element('a', { href: address }, 'This sample in Inspect’s viewer'), ', once ',
    element('code', {}, 'inspect view --log-dir DIR'), ` runs in the folder of ${file}: sample ${answer.task}, epoch ${epoch}.`);
}

function filmLink(answer) {
  return answer.row.F ? element('p', {}, element('a', { href: answer.row.F }, 'Film of this answer')) : null;
}

function rawAnswer(answer) {
  if (isActing(answer)) {
    if (!responseOf(answer)) return null;
    return element('details', { class: 'raw' }, element('summary', {}, 'Answer as given'), element('pre', { tabindex: '0' }, responseOf(answer)));
  }
  const kinds = [...new Set((answer.row.S || []).map(([, , kind]) => kind))];
  return element('section', { class: 'raw' }, element('h3', {}, 'Answer as given'),
    kinds.length ? element('p', { class: 'tags' }, kinds.map((kind) => element('span', { class: `part-${kind}` }, kind))) : null,
    responseOf(answer) ? element('pre', { tabindex: '0' }, markedText(responseOf(answer), answer.row.S || []))
      : element('p', { class: 'empty' }, 'The answer is empty.'));
}

// The text of an answer with what became of each part; positions count characters, not units of UTF-16.
function markedText(whole, spans) {
  const characters = spans.length ? Array.from(whole) : [];
  const pieces = [];
  let position = 0;
  spans.forEach(([start, end, kind]) => {
    pieces.push(characters.slice(position, start).join(''),
      element('span', { class: `part-${kind}`, title: kind }, characters.slice(start, end).join('')));
    position = end;
  });
  return spans.length ? [...pieces, characters.slice(position).join('')] : whole;
}

function promptBlock(answer) {
  const prompt = promptOf(answer);
  return prompt && element('details', { class: 'prompt' }, element('summary', {}, 'Prompt'), element('pre', { tabindex: '0' }, prompt));
}

function others(answer) {
  const found = othersOf(answer).filter((other) => other !== answer);
  if (!found.length) return null;
  return element('section', { class: 'others' }, element('h3', {}, 'This task in other runs'),
    element('ul', {}, found.map((other) => element('li', {},
      element('button', { type: 'button', onclick: () => jump(other) }, swatch(other.outcome), other.run.model,
        element('span', { class: 'kind' }, `${words(other.outcome)} · ${other.run.protocol}`)),
      element('button', { type: 'button', class: 'quiet', onclick: () => comparePair(answer.run, other.run, answer.task) }, 'side by side')))));
}

function jump(answer) {
  state.selected = answer;
  state.step = null;
  const place = placeOfSelected();
  if (place >= 0) bringIntoSight(place);
  renderList();
  renderDetail();
  writeAddress();
}
