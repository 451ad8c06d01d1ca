// A plan step by step: what was done, what changed, what failed and why, and how the world is by then.

const DONE = new Set(['executed', 'planned', 'additional_step', 'accepted']);
const KINDS = { additional_step: 'needless', accepted: 'done logged', cannot_tell: 'unknown logged' };

function replay(answer) {
  const steps = stepsOf(answer);
  if (!steps.length) return null;
  const scenes = scenesOf(answer);
  const turns = turnsOf(answer);
  const [title, noun] = isActing(answer) ? ['Episode', 'turn'] : [steps[0].outcome === 'planned' ? 'Plan that the planner found' : 'Plan', 'step'];
  const first = scenes.length ? -1 : 0;
  const tells = turns.length || steps.some((step) => step.added.length || step.removed.length);
  const box = element('section', { class: 'replay', 'aria-label': `${title} ${noun} by ${noun}` });
  const within = (place) => Math.min(steps.length - 1, Math.max(first, place));
  let at = (answer === state.selected || state.pair) && state.step !== null ? within(state.step) : steps.length - 1;
  const draw = (focus) => {
    const go = (to) => {
      state.selected = state.pair ? state.selected : answer;
      at = within(to);
      state.step = at;
      draw(true);
      writeAddress();
    };
    fill(box,
      element('div', { class: scenes.length ? 'stage' : null },
        element('div', { class: 'controls' }, element('h3', {}, title),
          element('button', { type: 'button', 'aria-label': `Previous ${noun}`, disabled: at === first, onclick: () => go(at - 1) }, '←'),
          element('span', { class: 'place', role: 'status' }, at < 0 ? 'the start' : `${noun} ${at + 1} of ${steps.length}`),
          element('button', { type: 'button', 'aria-label': `Next ${noun}`, disabled: at === steps.length - 1, onclick: () => go(at + 1) }, '→')),
        picture(scenes, at, at < 0 ? 'At the start' : `After ${noun} ${at + 1}, ${steps[at].action}`)),
      element('div', { class: tells ? 'columns' : '' },
        element('ol', { class: 'steps' }, steps.map((step, index) => stepItem(step, index, at, go, turns[index]))),
        tells && stateAfter(steps, at, noun, goalsAt(answer, turns[at]))));
    requestAnimationFrame(() => showChange(box));
    const current = box.querySelector('[aria-current]');
    if (focus && current) {
      current.focus({ preventScroll: true });
      current.scrollIntoView({ block: 'nearest' });
    }
    box.go = (by) => go(at + by);
  };
  draw(false);
  return box;
}

function stepItem(step, index, at, go, turn) {
  const done = DONE.has(step.outcome);
  const kind = KINDS[step.outcome] || (done ? 'done' : 'failed');
  const marks = { needless: '↺', done: '✓', failed: '✗', unknown: '?' };
  return element('li', { class: `step ${kind}${index > at ? ' later' : ''}` },
    element('button', { type: 'button', class: 'action', 'aria-current': index === at ? 'step' : null, onclick: () => go(index) },
      element('span', { class: 'mark', 'aria-hidden': 'true' }, marks[kind.split(' ')[0]]),
      element('code', {}, step.action),
      element('span', { class: done && kind !== 'needless' ? 'unseen' : 'verdict' }, words(step.outcome))),
    turn && turn.thought && element('details', { class: 'thought' }, element('summary', {}, 'What the agent said'), element('p', {}, turn.thought)),
    step.reason && element('p', { class: 'reason' }, step.reason),
    step.earlier && element('p', { class: 'earlier' }, step.earlier),
    changes(step.added, step.removed, step.hidden));
}

function changes(added, removed, hidden) {
  if (!added.length && !removed.length && !hidden) return null;
  return element('ul', { class: 'changes' },
    added.map((fact) => element('li', { class: 'added' }, element('span', { class: 'unseen' }, 'becomes true: '), fact)),
    removed.map((fact) => element('li', { class: 'removed' }, element('span', { class: 'unseen' }, 'becomes false: '), fact)),
    hidden ? element('li', { class: 'hidden-changes' }, `${plural(hidden, 'more change')}, not shown`) : null);
}

// The goals of an episode, as they are after a turn.
function goalsAt(answer, turn) {
  return turn && [element('h4', {}, 'Goals'), element('ul', { class: 'goals-then' }, goalsOf(answer).map(({ goal }, index) => (
    element('li', { class: turn.reached[index] ? 'reached' : 'open' },
      element('span', { class: 'unseen' }, turn.reached[index] ? 'reached: ' : 'not reached: '), goal))))];
}

// The net change from the start to a step.
function stateAfter(steps, at, noun, goals) {
  const net = new Map();
  for (const step of steps.slice(0, at + 1)) {
    for (const fact of step.added) if (net.get(fact) === 'removed') net.delete(fact); else net.set(fact, 'added');
    for (const fact of step.removed) if (net.get(fact) === 'added') net.delete(fact); else net.set(fact, 'removed');
  }
  const of = (kind) => [...net].filter(([, change]) => change === kind).map(([fact]) => fact).sort();
  return element('aside', { class: 'state', 'aria-label': `Changed since the start, after ${noun} ${at + 1}` },
    goals,
    element('h4', {}, 'Since the start'), net.size ? changes(of('added'), of('removed'), 0)
      : element('p', { class: 'empty' }, 'Nothing about the task’s objects has changed.'));
}
