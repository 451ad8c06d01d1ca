// The records. Each line of data is a chunk of compressed JSON in base64; the last line is the index of all answers.
// The details of answers are read when one of them is shown. The keys are those of explorer.py.

addEventListener('unhandledrejection', (event) => document.body.prepend(element('p', { class: 'notice', role: 'alert' },
  `This page cannot be read: ${event.reason.message}. It needs its whole file, and a browser of 2023 or later.`)));

const lines = byId('data').textContent.trim().split('\n');

function unpack(number) {
  const written = atob(lines[number]);
  const bytes = new Uint8Array(written.length);
  for (let place = 0; place < written.length; place += 1) bytes[place] = written.charCodeAt(place);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'))).json();
}

const packed = await unpack(lines.length - 1);

const OUTCOMES = Object.keys(packed.outcomes);
const SUCCESS = packed.success;
for (const [name, color] of Object.entries(packed.outcomes)) {
  document.styleSheets[0].insertRule(`.of-${name} { --c: var(--of-${name}, ${color}); }`);
}

const words = (name) => name.replace(/_/g, ' ');
const title = (name) => packed.titles[name] || words(name).replace(/^./, (first) => first.toUpperCase());

const added = packed.runs.map((run) => ({
  ...run,
  log: run.log || null,
  key: `${run.domain}/${run.ability}/${run.protocol}/${run.model}`,
  suite: `${run.domain}/${run.ability}`,
  answers: [],
}));
const runs = packed.order.map((place, number) => Object.assign(added[place], { number }));

// The fields of an answer that are not empty.
function fieldsAt(columns, place) {
  const row = {};
  for (const name of Object.keys(columns)) if (columns[name][place] !== null) row[name] = columns[name][place];
  return row;
}

const chunks = packed.chunks.map((columns, number) => {
  const chunk = { number };
  chunk.answers = columns.t.map((task, place) => (
    { run: added[columns.run[place]], task, outcome: columns.o[place], row: fieldsAt(columns, place), chunk }));
  for (const answer of chunk.answers) answer.run.answers.push(answer);
  return chunk;
});

const answers = runs.flatMap((run) => run.answers);
const byTask = new Map();
for (const answer of answers) {
  const place = `${answer.run.suite}/${answer.task}`;
  if (!byTask.has(place)) byTask.set(place, []);
  byTask.get(place).push(answer);
}

const prompts = {};  // of each suite, as a promise

async function readChunk(chunk) {
  const { suite } = chunk.answers[0].run;
  if (suite in packed.prompts) prompts[suite] ||= unpack(packed.prompts[suite]);
  const [{ columns, tiles, scenes }, promptsOfSuite] = await Promise.all([unpack(chunk.number), prompts[suite]]);
  chunk.answers.forEach((answer, place) => Object.assign(answer.row, fieldsAt(columns, place)));
  Object.assign(chunk, { tiles, scenes, prompts: promptsOfSuite, isRead: true });
}

const read = (answer) => { answer.chunk.reading ||= readChunk(answer.chunk); return answer.chunk.reading; };

const othersOf = (answer) => byTask.get(`${answer.run.suite}/${answer.task}`);
const answerOf = (run, task) => (byTask.get(`${run.suite}/${task}`) || []).find((other) => other.run === run);

// A task's name and what it is in words, as far as they are known; its id where the name is not.
const taskOf = (answer) => {
  const [name, instruction] = (packed.tasks[answer.run.domain] || {})[answer.task] || [];
  return { name: name === undefined ? answer.task : words(name), instruction: instruction || '' };
};

const errorOf = (answer) => {
  const error = answer.row.f;
  return error ? { kind: error[0], step: error[1], detail: error[2] } : null;
};
const notesOf = (answer) => answer.row.w || [];
const stepsOf = (answer) => (answer.row.s || []).map(([action, outcome, reason, earlier, added, removed, hidden]) => (
  { action, outcome, reason, earlier, added, removed, hidden }));
// Of each turn of an episode: which goals were reached after it, and the agent's words beside its command.
const turnsOf = (answer) => (answer.row.T || []).map(([reached, thought]) => (
  { reached: [...reached].map((held) => held === '1'), thought: thought || '' }));
const tileOf = (chunk, number) => {
  const [name, kind, marks, lines, zones] = JSON.parse(chunk.tiles[number]);
  return { name, kind, marks, lines, zones: zones.map(([label, within]) => [label, within.map((tile) => tileOf(chunk, tile))]) };
};
// For the start and each step, a function that returns the outermost tiles; nothing where there are no pictures.
const scenesOf = ({ row, chunk }) => (row.P || []).map((number) => (
  () => JSON.parse(chunk.scenes[number]).map((tile) => tileOf(chunk, tile))));
const attemptsOf = ({ run, task, chunk, row }) => (row.A || []).map((attempt) => ({ run, task, chunk, outcome: attempt.o, row: attempt }));
const isActing = (answer) => answer.run.ability === 'acting';
const goalsOf = (answer) => (answer.row.G || []).map(([kind, goal, satisfied, ...remarks]) => (
  { kind, goal, satisfied: Boolean(satisfied), remarks }));
const operatorsOf = (answer) => (answer.row.q || []).map(([name, status, precondition, effect, offences]) => (
  { name, status, precondition, effect, offences }));
const responseOf = (answer) => answer.row.r || '';
const promptOf = ({ chunk, task }) => {
  const numbers = chunk.prompts && chunk.prompts.tasks[task];
  return numbers ? numbers.map((number) => chunk.prompts.lines[number]).join('\n') : null;
};
const goldOf = (answer, operator) => (packed.gold[answer.run.domain] || {})[operator] || null;

const wholeText = (answer) => {
  const { name, instruction } = taskOf(answer);
  const error = errorOf(answer);
  return [answer.task, name, instruction, answer.run.model, error ? error.detail : '', ...notesOf(answer),
    ...goalsOf(answer).map((goal) => goal.goal), JSON.stringify(operatorsOf(answer)), responseOf(answer)].join('\n').toLowerCase();
};

let texts = null;  // the promise of the texts for the search
let textsAreRead = false;

// Read all answers for the search, and keep of each the text in which it can be found.
async function readTexts() {
  for (const chunk of chunks) {
    show('summary', element('p', { class: 'tally' }, `Reading answers: ${Math.round((100 * chunk.number) / chunks.length)} %`));
    const { columns } = await unpack(chunk.number);
    chunk.answers.forEach((answer, place) => {
      answer.text = wholeText({ ...answer, row: { ...answer.row, ...fieldsAt(columns, place) } });
    });
  }
  textsAreRead = true;
}
