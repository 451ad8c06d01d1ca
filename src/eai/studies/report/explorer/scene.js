// What a scene looks like: each object a tile in the tile of what it is in or on, as in the pictures of `eai export pictures`.

// What is said of each object, as one text.
function saidIn(tiles, place = '', found = new Map()) {
  for (const tile of tiles) {
    found.set(tile.name, JSON.stringify([place, tile.marks, tile.lines]));
    for (const [label, within] of tile.zones) saidIn(within, `${label} ${tile.name}`, found);
  }
  return found;
}

// The picture after a step, with a frame around what is not as it was before; -1 is the start.
function picture(scenes, at, caption) {
  if (!scenes.length) return null;
  const now = scenes[at + 1]();
  const [before, after] = [at < 0 ? null : saidIn(scenes[at]()), saidIn(now)];
  const shown = (tile) => {
    const changed = before && before.get(tile.name) !== after.get(tile.name);
    return element('div', { class: `tile ${tile.kind}${changed ? ' changed' : ''}` },
      element('strong', {}, tile.name, changed && element('span', { class: 'unseen' }, ' (changed)')),
      tile.marks.length ? element('span', { class: 'marks' }, tile.marks.map((mark) => element('span', {}, mark))) : null,
      tile.lines.map((line) => element('span', { class: 'line' }, line)),
      tile.zones.map(([label, within]) => element('div', { class: 'zone' }, element('span', { class: 'label' }, within.length ? label : `${label} (empty)`),
        within.length ? element('div', { class: 'tiles' }, within.map(shown)) : null)));
  };
  return element('figure', { class: 'picture' }, element('figcaption', {}, caption),
    element('div', { class: 'tiles', tabindex: '0', role: 'group', 'aria-label': 'Picture of the scene' }, now.map(shown)));
}

// Bring the first thing that changed into sight, where a picture is higher than its place.
function showChange(box) {
  const [frame, changed] = [box.querySelector('.picture > .tiles'), box.querySelector('.tile.changed')];
  if (frame && changed) frame.scrollTop = changed.getBoundingClientRect().top - frame.getBoundingClientRect().top - 40;
}
