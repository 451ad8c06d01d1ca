// The questions, and making elements. Text from the data only ever becomes text nodes.

const form = JSON.parse(document.getElementById('data').textContent);
const byId = (id) => document.getElementById(id);
const element = (tag, properties = {}, ...children) => {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith('on')) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
};
