// The page: reads its data, and joins scene, slider, panel and table.
import { GraspScene } from './scene.js';
import { GraspTable } from './table.js';
import { closingTime, lengthOf, postureAt, shownTime, stagesOf } from './motion.js';

const find = (id) => document.getElementById(id);
const data = JSON.parse(find('data').textContent);
data.grasps.forEach((grasp, index) => { grasp.rank = index + 1; });

let scene = null;  // stays null without WebGL
let grasp = null;
let time = 0;
let playing = 0;

function element(tag, text = '', attributes = {}) {
  const made = Object.assign(document.createElement(tag), attributes);
  made.textContent = text;
  return made;
}

// ---- What was found -------------------------------------------------------------------------

function showHead() {
  find('title').textContent = document.title;
  find('sub').textContent = `${data.grasps.length} of ${data.tried} candidates tried, friction ` +
      `${data.friction}`;
  const tile = (kind, value, label) => {
    const made = element('div', '', { className: `tile ${kind}` });
    made.append(element('b', value), element('span', label));
    find('tiles').append(made);
  };
  const counts = new Map();
  for (const { outcome, good } of data.grasps) {
    if (!good) counts.set(outcome, (counts.get(outcome) ?? 0) + 1);
  }
  tile('', data.grasps.length, 'candidates');
  tile('good', data.grasps.filter(({ outcome }) => outcome === 'force closure').length,
       'force closures');
  tile('good', Math.max(0, ...data.grasps.map(({ epsilon }) => epsilon)).toFixed(4),
       'best epsilon');
  for (const [outcome, count] of counts) tile('bad', count, outcome);
  for (const [name, value] of data.facts) {
    const row = find('facts').tBodies[0].insertRow();
    row.append(element('th', name), element('td', value));
  }
  addLinks(find('files'), 'Files: ', data.files);
}

function addLinks(place, words, files) {
  place.replaceChildren(...(files.length ? [words] : []));
  files.forEach((file, k) => place.append(
      k ? ', ' : '', element('a', file, { href: encodeURIComponent(file) })));
}

// ---- One grasp ------------------------------------------------------------------------------

function select(chosen) {
  grasp = chosen;
  stop();
  find('time').max = lengthOf(stagesOf(grasp)) || 1;
  scene?.select(grasp);
  table.mark(grasp);
  showPanel();
  showMarks();
  seek(lengthOf(stagesOf(grasp)));
  history.replaceState(null, '', `#candidate=${grasp.candidate}`);
}

/// The command that closes the hand there again.
function commandOf({ hand, start, direction, travel, preshape }) {
  if (!data.command) return '';
  const word = /^[\w.+:,@%/-]+$/.test(preshape) ? preshape
      : `'${preshape.replaceAll("'", "'\\''")}'`;
  const approach = !hand && travel > 0 ? ` --approach ${[...direction, travel].join(' ')}` : '';
  return `${data.command} --preshape ${word} --pose ${(hand ?? start).join(' ')}${approach}`;
}

function showPanel() {
  find('which').textContent = `Rank ${grasp.rank}: candidate ${grasp.candidate}`;
  const number = (name, value) => {
    const made = element('div');
    made.append(element('span', name), element('b', value));
    return made;
  };
  find('numbers').replaceChildren(
      number('outcome', grasp.outcome), number('epsilon', grasp.epsilon.toFixed(4)),
      ...(grasp.class ? [number('class', grasp.class)] : []),
      ...(grasp.holds === null ? [] : [number(`holds ${Number(data.mass.toPrecision(3))} kg any way up`,
          `${grasp.holds ? 'yes' : 'no'}, ${grasp.largestMass === null ? 'any mass' :
              `up to ${grasp.largestMass.toPrecision(3)} kg`}`)]),
      ...(grasp.volume === null ? [] : [number('volume', grasp.volume.toPrecision(4))]),
      number('contacts', grasp.contacts?.length ?? 0),
      number('approach', `${(1000 * grasp.travel).toFixed(1)} mm`),
      number('preshape', grasp.preshape));
  find('command').textContent = commandOf(grasp);
  find('again').hidden = !data.command;
  addLinks(find('links'), 'Files of this grasp: ', grasp.files);
  find('joints').tBodies[0].replaceChildren(...data.joints.map(({ name }) => {
    const row = element('tr');
    row.append(element('td', name), element('td'));
    return row;
  }));
  find('contacts').tBodies[0].replaceChildren(...(grasp.contacts ?? []).map(({ link, point }) => {
    const row = element('tr');
    row.append(element('td', data.links[link].name),
               element('td', `${point.map((x) => (1000 * x).toFixed(1)).join(', ')} mm`));
    return row;
  }));
}

function showJoints() {
  const { joints } = scene?.posture ?? postureAt(data, grasp, time);
  [...find('joints').rows].forEach((row, joint) => {
    row.cells[1].textContent = data.joints[joint].prismatic
        ? `${(1000 * joints[joint]).toFixed(2)} mm`
        : `${(joints[joint] * 180 / Math.PI).toFixed(2)}°`;
  });
}

// ---- The slider -----------------------------------------------------------------------------

function seek(to) {
  const length = lengthOf(stagesOf(grasp));
  time = Math.min(length, Math.max(0, to));
  find('time').value = length ? time : 1;
  find('moment').textContent = momentText();
  find('time').ariaValueText = find('moment').textContent;
  scene?.seek(time);
  showJoints();
}

function stopText({ link, time: at, by }) {
  return `${data.links[link].name} stops by the ${by}, ${at.toFixed(3)} s`;
}

function momentText() {
  const stages = stagesOf(grasp);
  const now = closingTime(grasp, stages, time);
  if (now === null) {
    const stage = stages.find(({ to }) => time <= to);
    if (!stage) return 'at the start';
    if (stage.name !== 'approach') return 'backs off to where it closes';
    return `approach: ${(1000 * grasp.travel * (1 - time / stage.to)).toFixed(1)} mm to go`;
  }
  const before = grasp.stops.filter((stop) => stop.time <= now + 1e-6);
  const last = before[before.length - 1];
  return `closing: ${now.toFixed(3)} s` + (last ? `; ${stopText(last)}` : '');
}

/// Where stages begin, and where links stop.
function showMarks() {
  const stages = stagesOf(grasp);
  const length = lengthOf(stages) || 1;
  find('marks').replaceChildren();
  const mark = (at, label, title) => {
    const made = element('button', label, { type: 'button', title, tabIndex: -1 });
    made.className = label ? 'stage' : 'stop';
    made.style.left = `${100 * at / length}%`;
    made.addEventListener('click', () => seek(at));
    find('marks').append(made);
  };
  for (const { name, from } of stages) mark(from, name, `${name} begins`);
  const closing = stages.find(({ name }) => name === 'closing');
  if (closing) {
    for (const stop of grasp.stops) mark(closing.from + shownTime(grasp, stop.time), '', stopText(stop));
  }
}

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  find('play').textContent = '▶';
}

function play() {
  if (playing) return stop();
  const length = lengthOf(stagesOf(grasp));
  if (time >= length) seek(0);
  find('play').textContent = '❚❚';
  let last = performance.now();
  const step = (now) => {
    seek(time + (now - last) / 1000);
    last = now;
    playing = time < length ? requestAnimationFrame(step) : stop();
  };
  playing = requestAnimationFrame(step);
}

// ---- What is shown --------------------------------------------------------------------------

const shows = [
  ['hand', true], ['object', true], ['see-through', true], ['contacts', true], ['cones', true],
  ['boxes', false], ...(data.obstacles.length ? [['obstacles', true]] : []),
].map(([name, on], k) => {
  const button = element('button', name, { type: 'button', title: `Show or hide (${k + 1})` });
  button.ariaPressed = String(on);
  button.addEventListener('click', () => show(name, button.ariaPressed !== 'true'));
  find('shows').append(button);
  return { name, button };
});

function show(name, on) {
  shows.find((candidate) => candidate.name === name).button.ariaPressed = String(on);
  if (!scene) return;
  if (name === 'see-through') return scene.setSeeThrough(on);
  scene[name].visible = on;
  scene.invalidate();
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
}

function isDark() {
  return document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === 'dark'
      : matchMedia('(prefers-color-scheme: dark)').matches;
}

// ---- Keys -----------------------------------------------------------------------------------

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.target.closest('select, input[type=number]')) return;
  const length = lengthOf(stagesOf(grasp));
  const step = length * (event.shiftKey ? 0.002 : 0.02);
  const actions = {
    ArrowLeft: () => { stop(); seek(time - step); },
    ArrowRight: () => { stop(); seek(time + step); },
    ArrowUp: () => select(table.next(grasp, -1) ?? grasp),
    ArrowDown: () => select(table.next(grasp, 1) ?? grasp),
    Home: () => { stop(); seek(0); },
    End: () => { stop(); seek(length); },
    ' ': event.target.closest('button, summary, a') ? undefined : play,
    f: () => scene?.frame(),
    d: () => setTheme(isDark() ? 'light' : 'dark'),
  };
  shows.forEach(({ button }, k) => { actions[k + 1] = () => button.click(); });
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

function copyCommand() {
  getSelection().selectAllChildren(find('command'));
  navigator.clipboard?.writeText(find('command').textContent)
      .then(() => { find('copy').textContent = 'Copied'; }, () => {});
}

// ---- Start ----------------------------------------------------------------------------------

showHead();
const table = new GraspTable(data.grasps, select);
try {
  scene = new GraspScene(find('canvas'), data);
} catch (error) {
  find('trouble').textContent = `Nothing can be drawn: ${error.message}. The tables work without.`;
  find('trouble').hidden = false;
}
find('theme').addEventListener('click', () => setTheme(isDark() ? 'light' : 'dark'));
find('time').addEventListener('input', () => { stop(); seek(Number(find('time').value)); });
find('play').addEventListener('click', play);
find('copy').addEventListener('click', copyCommand);
document.addEventListener('keydown', onKey);
const asked = new URLSearchParams(location.hash.slice(1));
if (data.grasps.length) {
  const wanted = data.grasps.find(({ candidate }) => String(candidate) === asked.get('candidate'));
  select(wanted ?? data.grasps[0]);
  if (asked.has('time')) seek(Number(asked.get('time')) * lengthOf(stagesOf(grasp)));
  for (const name of asked.getAll('show')) show(name, true);
} else {
  find('panel').hidden = true;
}
// For tests and for the console of the browser.
window.graspPage = { data, scene, select, seek, show, commandOf };
