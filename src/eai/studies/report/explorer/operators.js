// Operators: the data set's definition beside the answer's, with the predicates of what differs marked.

const CONNECTIVES = new Set(['and', 'or', 'not', 'when', 'forall', 'exists']);

function operators(answer) {
  const found = operatorsOf(answer);
  if (!found.length) return null;
  return element('section', { class: 'operators' }, element('h3', {}, 'Operators'),
    element('p', { class: 'key' }, element('mark', { class: 'missing' }, 'missing'), ' in the answer, ',
      element('mark', { class: 'additional' }, 'additional'), ' in the answer, the rest matches'),
    found.map((operator) => operatorItem(answer, operator)));
}

function operatorItem(answer, operator) {
  const gold = goldOf(answer, operator.name);
  const written = writtenOperator(responseOf(answer), operator.name);
  const sides = [['precondition', operator.precondition], ['effect', operator.effect]];
  return element('article', { class: 'operator' },
    element('h4', {}, element('code', {}, operator.name), operator.status !== 'compared' && element('span', { class: 'tag' }, words(operator.status))),
    gold || written ? element('div', { class: 'columns even' },
      definition('Data set', gold, sides, 2, 'missing'), definition('Answer', written, sides, 1, 'additional')) : null,
    element('dl', { class: 'names' }, sides.map(([name, parts]) => sideNames(name, parts))),
    operator.offences.length ? element('ul', { class: 'offences' }, operator.offences.map((offence) => element('li', {},
      `${words(String(offence.offence))} in the ${offence.place}: `, element('code', {}, String(offence.name))))) : null);
}

function sideNames(name, [matched, additional, missing]) {
  const chips = (values, kind) => values.map((value) => element('span', { class: `chip ${kind}` },
    element('span', { class: 'unseen' }, `${kind}: `), value));
  return element('div', {}, element('dt', {}, name),
    element('dd', {}, chips(matched, 'matched'), chips(missing, 'missing'), chips(additional, 'additional'),
      !matched.length && !missing.length && !additional.length && '–'));
}

function definition(heading, source, sides, part, mark) {
  return element('div', { class: 'definition' }, element('h5', {}, heading), source
    ? sides.map(([name, parts]) => [element('span', { class: 'side' }, name),
      element('pre', {}, pretty(groupAfter(source, `:${name}`), new Set(parts[part].flatMap(predicatesIn)), mark))])
    : element('p', { class: 'empty' }, 'none'));
}

// A clause stands for its predicates, a name alone for itself.
function predicatesIn(clause) {
  const heads = [...clause.matchAll(/\(([^\s()?]+)/g)].map((match) => match[1]);
  return clause.startsWith('(') ? heads.filter((head) => !CONNECTIVES.has(head)) : [clause];
}

// The text of an operator in an answer, for showing only; scoring reads answers by itself.
function writtenOperator(response, name) {
  const plain = response.replace(/\\n/g, '\n').replace(/\\t/g, ' ').replace(/\\"/g, '"');
  const escaped = name.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');
  const heads = [...plain.matchAll(new RegExp(`\\(\\s*:action\\s+${escaped}(?![\\w-])`, 'gi'))];
  return heads.length ? balanced(plain, heads[heads.length - 1].index) : null;
}

function groupAfter(source, keyword) {
  const head = source.toLowerCase().indexOf(keyword);
  const open = head < 0 ? -1 : source.indexOf('(', head);
  return open < 0 ? '' : balanced(source, open);
}

function balanced(source, open) {
  let depth = 0;
  for (let index = open; index < source.length; index += 1) {
    if (source[index] === '(') depth += 1;
    else if (source[index] === ')') depth -= 1;
    if (!depth) return source.slice(open, index + 1);
  }
  return source.slice(open);
}

// A formula with one part a line where it is too long for one, as text nodes and marks.
function pretty(source, marked, kind) {
  const tokens = source.match(/[()]|[^\s()]+/g) || [];
  const pieces = [];
  let depth = 0;
  tokens.forEach((token, index) => {
    const head = tokens[index - 1] === '(';
    if (token === '(') {
      if (depth) pieces.push(compact(tokens, index) && depth > 4 ? ' ' : `\n${'  '.repeat(depth)}`);
      depth += 1;
      pieces.push('(');
    } else if (token === ')') {
      depth = Math.max(0, depth - 1);
      pieces.push(')');
    } else {
      if (!head) pieces.push(' ');
      pieces.push(head && marked.has(token.toLowerCase()) ? element('mark', { class: kind }, token) : token);
    }
  });
  return joinNegations(pieces);
}

const compact = (tokens, index) => tokens.indexOf(')', index) - index < 6;

// `(not` and the atom it negates stay on one line.
function joinNegations(pieces) {
  return pieces.map((piece, index) => (
    typeof piece === 'string' && piece.startsWith('\n') && pieces[index - 1] === 'not' ? ' ' : piece));
}
