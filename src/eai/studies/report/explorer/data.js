// The records, unpacked. The keys are those of explorer.py.

const packed = JSON.parse(document.getElementById('data').textContent);
const text = (number) => packed.texts[number];

const OUTCOMES = ['success', 'partly_right', 'goal_missed', 'parsing', 'hallucination', 'argument_number',
  'affordance', 'missing_step', 'wrong_order', 'additional_step', 'uncategorised', 'slip', 'not_answered', 'excluded'];

const words = (name) => name.replace(/_/g, ' ');
const title = (name) => packed.titles[name] || words(name).replace(/^./, (first) => first.toUpperCase());

const runs = packed.runs.map((run, number) => ({
  number,
  domain: run.domain,
  ability: run.ability,
  protocol: run.protocol,
  model: run.model,
  log: run.log || null,
  key: `${run.domain}/${run.ability}/${run.protocol}/${run.model}`,
  suite: `${run.domain}/${run.ability}`,
}));

const answers = [];
const byTask = new Map();
packed.runs.forEach((run, number) => {
  for (const row of run.answers) {
    const answer = { number: answers.length, run: runs[number], task: text(row.t), outcome: row.o, row };
    answers.push(answer);
    const place = `${answer.run.suite}/${answer.task}`;
    if (!byTask.has(place)) byTask.set(place, []);
    byTask.get(place).push(answer);
  }
});

const othersOf = (answer) => byTask.get(`${answer.run.suite}/${answer.task}`);
const answerOf = (run, task) => (byTask.get(`${run.suite}/${task}`) || []).find((other) => other.run === run);

// A task's name and what it is in words, as far as they are known; its id where the name is not.
const taskOf = (answer) => {
  const [name, instruction] = (packed.tasks[answer.run.domain] || {})[answer.task] || [];
  return { name: name === undefined ? answer.task : words(text(name)), instruction: instruction === undefined ? '' : text(instruction) };
};

const errorOf = (answer) => {
  const error = answer.row.f;
  return error ? { kind: error[0], step: error[1], detail: text(error[2]) } : null;
};
const notesOf = (answer) => (answer.row.w || []).map(text);
const stepsOf = (answer) => (answer.row.s || []).map((number) => {
  const [action, outcome, reason, earlier, added, removed, hidden] = packed.steps[number];
  return { action: text(action), outcome: text(outcome), reason: text(reason), earlier: text(earlier),
    added: added.map(text), removed: removed.map(text), hidden };
});
// Of each turn of an episode: which goals were reached after it, and the agent's words beside its command.
const turnsOf = (answer) => (answer.row.T || []).map(([reached, thought]) => (
  { reached: [...reached].map((held) => held === '1'), thought: thought === null ? '' : text(thought) }));
const tileOf = (number) => {
  const [name, kind, marks, lines, zones] = packed.tiles[number];
  return { name: text(name), kind, marks: marks.map(text), lines: lines.map(text),
    zones: zones.map(([label, within]) => [text(label), within.map(tileOf)]) };
};
// The outermost tiles after each step, those at the start first; nothing where there are no pictures.
const scenesOf = (answer) => (answer.row.P || []).map((number) => packed.scenes[number]);
const attemptsOf = (answer) => (answer.row.A || []).map((row) => ({ run: answer.run, task: answer.task, outcome: row.o, row }));
const isActing = (answer) => answer.run.ability === 'acting';
const goalsOf = (answer) => (answer.row.G || []).map(([kind, goal, satisfied, ...remarks]) => (
  { kind, goal: text(goal), satisfied: Boolean(satisfied), remarks: remarks.map(text) }));
const operatorsOf = (answer) => (answer.row.q || []).map((number) => {
  const [name, status, precondition, effect, offences] = packed.operators[number];
  const texts = (side) => side.map((parts) => parts.map(text));
  return { name, status, precondition: texts(precondition), effect: texts(effect), offences };
});
const responseOf = (answer) => (answer.row.r === undefined ? '' : text(answer.row.r));
const promptOf = (answer) => {
  const lines = (packed.prompts[answer.run.suite] || {})[answer.task];
  return lines ? lines.map(text).join('\n') : null;
};
const goldOf = (answer, operator) => (packed.gold[answer.run.domain] || {})[operator] || null;

const wholeText = (answer) => {
  if (answer.text === undefined) {
    const error = errorOf(answer);
    const goals = goalsOf(answer).map((goal) => goal.goal);
    const { name, instruction } = taskOf(answer);
    answer.text = [answer.task, name, instruction, answer.run.model, error ? error.detail : '', ...notesOf(answer), ...goals,
      responseOf(answer)].join('\n').toLowerCase();
  }
  return answer.text;
};
