// The page of a task: bodies that move through poses at given times, a slider, and marks of its stages.
import { Box3, Group, Mesh, Quaternion, Raycaster, Vector3 } from 'three';
import { geometryOf } from './geometry.js';
import { Stage, cornersOf, material, setPose } from './stage.js';

const find = (id) => document.getElementById(id);
const data = JSON.parse(find('data').textContent);
const length = data.times[data.times.length - 1];
let scene = null;  // stays null without WebGL
let time = 0;
let playing = 0;

class TaskScene extends Stage {
  constructor(canvas) {
    super(canvas);
    const geometries = data.meshes.map(geometryOf);
    this.groups = {};
    this.nodes = data.tracks.map(({ name, kind, mesh, color }) => {
      const node = new Mesh(geometries[mesh], material(color));
      node.name = name;
      this.groups[kind] ??= new Group();
      this.groups[kind].add(node);
      return node;
    });
    this.scene.add(...Object.values(this.groups));
    this.seek(0);
    this.watch(canvas);
  }

  /// Everything as it is at that time, between two key frames on the straight way.
  seek(to) {
    const next = Math.max(1, data.times.findIndex((key) => key >= to));
    data.tracks.forEach(({ poses }, k) => {
      const [a, b] = [poses[Math.min(next - 1, poses.length - 1)], poses[Math.min(next, poses.length - 1)]];
      setPose(this.nodes[k], a);
      if (a !== b) {
        const part = (to - data.times[next - 1]) / (data.times[next] - data.times[next - 1]);
        this.nodes[k].position.lerp(new Vector3(b[0], b[1], b[2]), part);
        this.nodes[k].quaternion.slerp(new Quaternion(b[4], b[5], b[6], b[3]), part);
      }
    });
    this.invalidate();
  }

  /// Of some sides that from which the surroundings hide the object least, on all of its way.
  bestDirection() {
    const { poses } = data.tracks.find(({ kind }) => kind === 'object');
    const hidden = (towards) => poses.filter((pose, k) => k % 8 === 0 && this.groups.surroundings &&
        new Raycaster(new Vector3(pose[0], pose[1], pose[2] + 0.05), towards)
            .intersectObject(this.groups.surroundings).length).length;
    const sides = [[1, -0.35, 0.45], [-0.5, 1, 0.6], [-0.5, -1, 0.6], [-1, -0.4, 0.7]]
        .map((side) => new Vector3(...side).normalize());
    return sides.reduce((best, side) => (hidden(side) < hidden(best) ? side : best));
  }

  /// Robot and object fill the picture.
  frame() {
    this.scene.updateMatrixWorld(true);
    const box = new Box3();
    const corners = [];
    data.tracks.forEach(({ kind }, k) => {
      if (kind === 'surroundings') return;
      box.expandByObject(this.nodes[k]);
      corners.push(...cornersOf(this.nodes[k]));
    });
    this.towards ??= this.bestDirection();
    this.look(corners, box.getCenter(new Vector3()), this.towards);
  }
}

function seek(to) {
  time = Math.min(length, Math.max(0, to));
  find('time').value = time;
  const stage = data.stages.filter(({ from }) => from <= time + 1e-9).pop();
  find('moment').textContent = `${time.toFixed(2)} s of ${length.toFixed(2)} s` +
      (stage ? `: ${stage.name}` : '');
  scene?.seek(time);
}

function stop() {
  cancelAnimationFrame(playing);
  playing = 0;
  find('play').textContent = '▶';
}

function play() {
  if (playing) return stop();
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

function showMarks() {
  let free = 0;  // names of short stages would lie on each other
  for (const { name, from } of data.stages) {
    const hasRoom = from >= free;
    if (hasRoom) free = from + 0.07 * length;
    const mark = Object.assign(document.createElement('button'), {
      type: 'button', title: `${name} begins`, tabIndex: -1, className: hasRoom ? 'stage' : 'stop',
      textContent: hasRoom ? name : '' });
    mark.style.left = `${100 * from / length}%`;
    mark.addEventListener('click', () => { stop(); seek(from); });
    find('marks').append(mark);
  }
  if (!length) find('timeline').hidden = true;
}

function showGroups() {
  for (const [name, group] of Object.entries(scene.groups)) {
    const button = Object.assign(document.createElement('button'), {
      type: 'button', textContent: name, ariaPressed: 'true' });
    button.addEventListener('click', () => {
      group.visible = !group.visible;
      button.ariaPressed = String(group.visible);
      scene.invalidate();
    });
    find('shows').append(button);
  }
}

function turnTheme() {
  const { dataset } = document.documentElement;
  const isDark = dataset.theme ? dataset.theme === 'dark'
      : matchMedia('(prefers-color-scheme: dark)').matches;
  dataset.theme = isDark ? 'light' : 'dark';
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const action = {
    ArrowLeft: () => { stop(); seek(time - 0.02 * length); },
    ArrowRight: () => { stop(); seek(time + 0.02 * length); },
    Home: () => { stop(); seek(0); },
    End: () => { stop(); seek(length); },
    ' ': event.target.closest('button, a') ? undefined : play,
    f: () => scene?.frame(),
    d: turnTheme,
  }[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

find('time').max = length || 1;
showMarks();
try {
  scene = new TaskScene(find('canvas'));
  showGroups();
} catch (error) {
  find('trouble').textContent = `Nothing can be drawn: ${error.message}. The tables work without.`;
  find('trouble').hidden = false;
}
find('theme').addEventListener('click', turnTheme);
find('time').addEventListener('input', () => { stop(); seek(Number(find('time').value)); });
find('play').addEventListener('click', play);
document.addEventListener('keydown', onKey);
seek(Number(new URLSearchParams(location.hash.slice(1)).get('time') ?? 0) * length);
// For tests and for the console of the browser.
window.taskPage = { data, scene, seek };
