// Shows the task and its turns, and sends one line at a time. Text from the program only ever becomes text nodes.

const byId = (id) => document.getElementById(id);
const line = byId('line');
let shown = JSON.parse(byId('data').textContent);
let waits = false;
const isTouch = window.matchMedia('(pointer: coarse)').matches; // there a field in focus opens a keyboard over the page

const made = (tag, name, text) => {
  const element = document.createElement(tag);
  element.className = name;
  element.textContent = text;
  return element;
};

const turn = ([said, told, kind]) => {
  const item = made('li', kind, '');
  const title = made('p', 'said', said);
  if (kind === 'failed') title.append(made('span', 'mark', 'failed'));
  item.append(title, made('pre', 'told', told));
  return item;
};

// The words that may stand where one is being typed, each behind what is typed before it.
const complete = () => {
  const [, before, word] = line.value.match(/^(.*[\s,(])?(.*)$/);
  const words = shown.words[before && before.trim() ? 1 : 0];
  const fit = words.filter((each) => each.toLowerCase().includes(word.toLowerCase())).slice(0, 100);
  byId('words').replaceChildren(...fit.map((each) => {
    const option = document.createElement('option');
    option.value = (before || '') + each;
    return option;
  }));
};

const show = (state) => {
  const isNew = state.number !== shown.number;
  shown = state;
  byId('suite').textContent = state.title;
  byId('progress').textContent = `Task ${state.number} of ${state.total}`;
  byId('rules').textContent = state.rules;
  byId('opening').textContent = state.opening;
  const log = byId('log');
  if (isNew) {
    log.replaceChildren();
    byId('suite').scrollIntoView();
    byId('task-title').scrollIntoView();
  }
  log.append(...state.log.slice(log.children.length).map(turn));
  byId('pictures').replaceChildren(...state.pictures.map((url, place) => {
    const picture = made('img', 'picture', '');
    picture.src = url;
    picture.alt = `Picture ${place + 1} of the world now`;
    return picture;
  }));
  byId('nothing').hidden = state.log.length > 0;
  log.hidden = state.log.length === 0;
  byId('entry').hidden = state.over;
  byId('over').hidden = !state.over;
  byId('next').hidden = state.last;
  byId('over-text').textContent = state.last ? 'All tasks are over. You can close this page.' : 'This task is over.';
  complete();
  if (log.lastElementChild) log.lastElementChild.scrollIntoView();
  if (!isTouch) (state.over ? byId('next') : line).focus();
};

const send = async (text) => {
  if (waits) return;
  waits = true;
  byId('remark').textContent = '';
  try {
    const reply = await fetch(`/${shown.at}`, { method: 'POST', body: text });
    if (!reply.ok) throw new Error();
    const state = await reply.json();
    if (state.taken) line.value = '';
    else byId('remark').textContent = 'Not sent: the task has gone on in another window. Here is how it stands.';
    show(state);
  } catch {
    byId('remark').textContent = 'The program has stopped; its terminal says why. What you did so far is kept. When it runs again, reload this page.';
  }
  waits = false;
};

byId('entry').addEventListener('submit', (event) => { event.preventDefault(); if (line.value.trim()) send(line.value); });
line.addEventListener('input', complete);
byId('help').addEventListener('click', () => send('help'));
byId('look').addEventListener('click', () => send('LOOK'));
byId('possible').addEventListener('click', () => send(`? ${line.value}`));
byId('done').addEventListener('click', () => { if (window.confirm('End this task? It is won if all goals hold now, and lost otherwise.')) send('DONE'); });
byId('next').addEventListener('click', () => send(''));
show(shown);
