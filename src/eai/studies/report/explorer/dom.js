// Making elements. Text from records only ever becomes text nodes.

const element = (tag, properties = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === 'class') made.className = value;
    else if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value === true ? '' : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
};
const byId = (id) => document.getElementById(id);
const fill = (place, ...children) => place.replaceChildren(...children.flat(Infinity).filter(Boolean));
const show = (place, ...children) => fill(byId(place), ...children);

const swatch = (outcome) => element('span', { class: `swatch of-${outcome}`, 'aria-hidden': 'true' });
const badge = (outcome) => element('span', { class: 'badge' }, swatch(outcome), words(outcome));
const plural = (count, noun) => `${count.toLocaleString('en')} ${noun}${count === 1 ? '' : 's'}`;

// A bar of coloured shares; parts are {outcome, count}.
const stack = (parts) => {
  const total = parts.reduce((sum, part) => sum + part.count, 0);
  const label = parts.map((part) => `${words(part.outcome)} ${part.count}`).join(', ');
  return element('div', { class: 'stack', role: 'img', 'aria-label': label }, parts.map((part) => {
    const piece = element('span', { class: `of-${part.outcome}`, title: `${words(part.outcome)}: ${part.count}` });
    piece.style.flexGrow = String(part.count / total);
    return piece;
  }));
};
const countOutcomes = (items) => {
  const counts = new Map();
  for (const item of items) counts.set(item.outcome, (counts.get(item.outcome) || 0) + 1);
  return OUTCOMES.filter((outcome) => counts.has(outcome)).map((outcome) => ({ outcome, count: counts.get(outcome) }));
};
