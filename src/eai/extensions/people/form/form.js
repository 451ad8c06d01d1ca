// One question at a time. Answers and times are kept in this browser, if it lets us, until they are saved.

const questions = form.questions;
const place = `eai form ${form.domain} ${form.ability} ${questions.map((question) => question.sha256.slice(0, 8)).join('')}`;
const kept = { answers: {}, seconds: {}, person: '' };
try { Object.assign(kept, JSON.parse(localStorage.getItem(place) || '{}')); } catch { /* a browser without a memory */ }
const keep = () => { try { localStorage.setItem(place, JSON.stringify(kept)); } catch { /* likewise */ } };

let current = 0;
let table = null;
let since = null;
const task = () => questions[current].task;
const isAnswered = (question) => Boolean((kept.answers[question.task] || '').trim());

// Seconds while the question is in sight and no dialog is before it.
const tick = () => {
  const now = performance.now();
  if (since !== null) kept.seconds[task()] = (kept.seconds[task()] || 0) + (now - since) / 1000;
  const away = document.hidden || document.querySelector('dialog[open]') !== null;
  since = away ? null : now;
};

const remark = () => {
  const text = byId('written').value.trim();
  const says = byId('remark');
  says.className = 'hint';
  if (!text) { says.textContent = 'No answer yet.'; return; }
  try { JSON.parse(text); says.textContent = 'This can be read as JSON.'; says.classList.add('right'); } catch {
    says.textContent = 'This is not JSON as a whole. Whether that matters is said in the question.'; says.classList.add('wrong');
  }
};

// Not the task's id, which may say more than the question does.
const label = (question, number) => `${number + 1} of ${questions.length}${isAnswered(question) ? ' ✓' : ''}`;
const list = () => byId('jump').replaceChildren(...questions.map((question, number) => element('option', { value: number }, label(question, number))));

const write = (text) => {
  kept.answers[task()] = text;
  keep();
  byId('jump').options[current].textContent = label(questions[current], current);
  remark();
};

const useTable = (on) => {
  byId('as-text').setAttribute('aria-pressed', String(!on));
  byId('as-table').setAttribute('aria-pressed', String(on));
  byId('table').hidden = !on;
  byId('written').readOnly = on;
  byId('written-label').textContent = on ? 'Text of the answer, as the table has it' : 'Text of the answer';
  if (!on) return;
  table = tableOf(task(), () => { byId('written').value = table.text(); write(byId('written').value); });
  const hint = element('p', { class: 'hint' }, 'The table begins empty. What you enter replaces the text below.');
  byId('table').replaceChildren(hint, ...table.boxes);
};

const show = (number) => {
  tick();
  current = number;
  const { system, user } = questions[number];
  byId('system-part').hidden = system === null;
  byId('system').textContent = system || '';
  byId('user').textContent = user;
  byId('written').value = kept.answers[task()] || '';
  byId('previous').disabled = number === 0;
  byId('next').disabled = number === questions.length - 1;
  byId('jump').value = String(number);
  document.querySelector('.question').scrollTop = 0;
  useTable(false);
  remark();
  keep();
};

const fileName = () => `${byId('person').value.trim().replace(/[^\p{L}\p{N}_.-]+/gu, '_').replace(/^\.+/, '') || 'person'}${form.suffix}`;
const described = () => {
  const done = questions.filter(isAnswered).length;
  const rest = done < questions.length ? ' Those without an answer are saved as such and count as failed.' : '';
  byId('state').textContent = `${done} of ${questions.length} questions answered.${rest}`;
  byId('file').textContent = `The file will be ${fileName()}. Send it to whoever asked you.`;
};

const save = () => {
  tick();
  const rows = questions.map((question) => ({
    identifier: question.task,
    llm_output: kept.answers[question.task] || '',
    seconds: Math.round(kept.seconds[question.task] || 0),
    prompt_sha256: question.sha256,
  }));
  const address = URL.createObjectURL(new Blob([`${JSON.stringify(rows, null, 1)}\n`], { type: 'application/json' }));
  element('a', { href: address, download: fileName() }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
};

byId('suite').textContent = `${form.title}, ${form.ability.replace(/_/g, ' ')}`;
byId('welcome-text').textContent = `There ${questions.length === 1 ? 'is one question' : `are ${questions.length} questions`}, one at a time. You can go back and change answers.`;
byId('ways').hidden = !form.goals && !form.operators;
byId('person').value = kept.person;
list();
byId('jump').addEventListener('change', (event) => show(Number(event.target.value)));
byId('previous').addEventListener('click', () => show(current - 1));
byId('next').addEventListener('click', () => show(current + 1));
byId('written').addEventListener('input', (event) => write(event.target.value));
byId('as-text').addEventListener('click', () => useTable(false));
byId('as-table').addEventListener('click', () => useTable(true));
byId('open-save').addEventListener('click', () => { tick(); described(); byId('save').showModal(); since = null; });
byId('person').addEventListener('input', (event) => { kept.person = event.target.value; keep(); described(); });
byId('download').addEventListener('click', save);
byId('clear').addEventListener('click', () => {
  if (!window.confirm('Erase all answers on this page?')) return;
  Object.assign(kept, { answers: {}, seconds: {} });
  list();
  show(current);
  described();
});
for (const dialog of document.querySelectorAll('dialog')) dialog.addEventListener('close', tick);
document.addEventListener('visibilitychange', tick);
window.addEventListener('pagehide', () => { tick(); keep(); });
show(0);
byId('welcome').showModal();
since = null;
