// Tables that a person may fill in; the page turns them into the text of an answer.

const WORDS = ['\u0001predicate', '\u0001first', '\u0001second'];
const LABELS = { 'node goals': 'State goals', 'edge goals': 'Relation goals', 'action goals': 'Action goals' };
const KINDS = { 1: 'action', 2: 'state', 3: 'relation' };
const OBJECTS = ['', 'object', 'other object'];

// The value with the words of a pattern replaced.
const filled = (pattern, words) => {
  if (typeof pattern === 'string') return WORDS.includes(pattern) ? words[WORDS.indexOf(pattern)] : pattern;
  if (Array.isArray(pattern)) return pattern.map((part) => filled(part, words));
  return Object.fromEntries(Object.entries(pattern).map(([key, part]) => [key, filled(part, words)]));
};

// A line a goal: which words a goal of this kind has, in the order of the pattern.
const goalSection = (name, pattern, changed) => {
  const used = WORDS.map((word, place) => place).filter((place) => JSON.stringify(pattern).includes(JSON.stringify(WORDS[place])));
  const lines = element('div');
  const add = () => {
    const hint = (place) => OBJECTS[place] || KINDS[used.length];
    const inputs = used.map((place) => element('input', { 'aria-label': hint(place), placeholder: hint(place), oninput: changed, spellcheck: 'false' }));
    const denied = element('input', { type: 'checkbox', onchange: changed });
    const line = element('div', { class: 'line' }, ...inputs);
    if (Array.isArray(pattern)) line.append(element('label', {}, denied, ' not'));
    line.append(element('button', { type: 'button', 'aria-label': 'Remove this goal', onclick: () => { line.remove(); changed(); } }, '×'));
    line.read = () => {
      const words = [];
      used.forEach((place, i) => { words[place] = inputs[i].value.trim(); });
      if (inputs.every((input) => !input.value.trim())) return null;
      return denied.checked ? ['not', filled(pattern, words)] : filled(pattern, words);
    };
    lines.append(line);
  };
  add();
  const more = element('button', { type: 'button', onclick: add }, 'Another one');
  const box = element('fieldset', {}, element('legend', {}, LABELS[name] || name), lines, element('p', { class: 'row' }, more));
  box.read = () => [...lines.children].map((line) => line.read()).filter((goal) => goal !== null);
  return box;
};

const goalTable = (changed) => {
  const sections = Object.entries(form.goals).map(([name, [pattern]]) => [name, goalSection(name, pattern, changed)]);
  return {
    boxes: sections.map(([, box]) => box),
    text: () => JSON.stringify(Object.fromEntries(sections.map(([name, box]) => [name, box.read()])), null, 1),
  };
};

const operatorTable = (task, changed) => {
  const parts = form.operators[task].map(({ name, parameters }) => {
    const area = (label) => element('textarea', { 'aria-label': `${label} of ${name}`, oninput: changed, spellcheck: 'false' });
    const before = area('precondition'), after = area('effect');
    const box = element('fieldset', {}, element('legend', {}, name, ' ', element('code', {}, parameters)),
      element('label', { class: 'field' }, 'Precondition', before), element('label', { class: 'field' }, 'Effect', after));
    const text = () => `(:action ${name}\n  :parameters ${parameters}\n  :precondition ${before.value.trim() || '()'}\n  :effect ${after.value.trim() || '()'}\n)`;
    return { box, text };
  });
  return { boxes: parts.map((part) => part.box), text: () => JSON.stringify({ output: parts.map((part) => part.text()).join('\n') }) };
};

const tableOf = (task, changed) => {
  if (form.goals) return goalTable(changed);
  return form.operators ? operatorTable(task, changed) : null;
};
