// The table of all candidates: sorts, filters, and says which one was chosen.
const COLUMNS = [
  { title: 'Rank', key: (g) => g.rank },
  { title: 'Candidate', key: (g) => g.candidate },
  { title: 'Outcome', key: (g) => g.outcome, text: true },
  { title: 'Epsilon', key: (g) => g.epsilon, show: (g) => g.epsilon.toFixed(4), down: true },
  { title: 'Class', key: (g) => g.class ?? '', text: true },
  { title: 'Holds [kg]', down: true,
    key: (g) => (g.holds === null ? -1 : g.largestMass ?? Infinity),
    show: (g) => (g.holds === null ? '–' : g.largestMass?.toPrecision(3) ?? 'any') },
  { title: 'Volume', key: (g) => g.volume ?? -1, down: true,
    show: (g) => (g.volume === null ? '–' : g.volume.toPrecision(4)) },
  { title: 'Contacts', key: (g) => g.contacts?.length ?? 0, down: true },
  { title: 'Links', key: (g) => new Set(g.contacts?.map((c) => c.link)).size, down: true },
  { title: 'Approach [mm]', key: (g) => g.travel, show: (g) => (1000 * g.travel).toFixed(1) },
  { title: 'From', key: (g) => g.source, text: true },
  { title: 'Preshape', key: (g) => g.preshape, text: true },
];

const find = (id) => document.getElementById(id);

export class GraspTable {
  /// `choose(grasp)` is called when the user chooses another one.
  constructor(grasps, choose) {
    this.choose = choose;
    if (grasps.some((grasp) => grasp.trials)) {
      COLUMNS.splice(3, 0, { title: 'Trials', key: (g) => g.trials ?? '', text: true });
    }
    this.grasps = grasps;
    this.body = find('grasps').tBodies[0];
    this.rows = new Map(grasps.map((grasp) => [grasp, this.rowOf(grasp)]));
    this.buildHead();
    this.fill('outcome', (grasp) => grasp.outcome);
    this.fill('preshape', (grasp) => grasp.preshape);
    for (const id of ['outcome', 'preshape', 'least']) {
      find(id).addEventListener('input', () => this.update());
    }
    this.sort = { column: COLUMNS[0], sign: 1 };
    this.update();
  }

  rowOf(grasp) {
    const row = document.createElement('tr');
    for (const { key, show = key, text } of COLUMNS) {
      const cell = row.insertCell();
      cell.textContent = show(grasp);
      if (text) cell.className = 'text';
    }
    row.cells[2].classList.add(grasp.good ? 'yes' : 'no');
    row.addEventListener('click', () => this.choose(grasp));
    return row;
  }

  buildHead() {
    const head = find('grasps').tHead.rows[0];
    for (const column of COLUMNS) {
      const cell = document.createElement('th');
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = column.title;
      cell.className = column.text ? 'text' : '';
      cell.append(button);
      head.append(cell);
      button.addEventListener('click', () => this.sortBy(column, cell));
    }
  }

  /// The same column again turns the order round.
  sortBy(column, cell) {
    const again = this.sort.column === column && cell.ariaSort;
    this.sort = { column, sign: again ? -this.sort.sign : column.down ? -1 : 1 };
    for (const other of cell.parentNode.cells) other.ariaSort = null;
    cell.ariaSort = this.sort.sign > 0 ? 'ascending' : 'descending';
    this.update();
  }

  /// The choices of a filter, with how many grasps each has.
  fill(id, key) {
    const counts = new Map();
    for (const grasp of this.grasps) counts.set(key(grasp), (counts.get(key(grasp)) ?? 0) + 1);
    find(id).append(new Option('all', ''));
    for (const [value, count] of counts) find(id).append(new Option(`${value} (${count})`, value));
  }

  /// Fills the table with those that pass the filters, in order.
  update() {
    const { column: { key }, sign } = this.sort;
    const [outcome, preshape] = [find('outcome').value, find('preshape').value];
    const least = Number(find('least').value) || 0;
    const compare = (a, b) => (typeof a === 'string' ? a.localeCompare(b) : a - b);
    this.shown = this.grasps
        .filter((grasp) => (!outcome || grasp.outcome === outcome) &&
            (!preshape || grasp.preshape === preshape) && grasp.epsilon >= least)
        .sort((a, b) => sign * compare(key(a), key(b)) || a.rank - b.rank);
    this.body.replaceChildren(...this.shown.map((grasp) => this.rows.get(grasp)));
    find('count').textContent = `${this.shown.length} of ${this.grasps.length}`;
  }

  /// The one `by` rows below the given one among those that are shown.
  next(grasp, by) {
    const at = this.shown.indexOf(grasp);
    const last = this.shown.length - 1;
    return this.shown[at < 0 ? 0 : Math.min(last, Math.max(0, at + by))];
  }

  mark(grasp) {
    this.body.querySelector('[aria-selected]')?.removeAttribute('aria-selected');
    for (const row of this.rows.values()) row.removeAttribute('aria-selected');
    const row = this.rows.get(grasp);
    row.ariaSelected = 'true';
    const list = find('list');  // without moving the page
    if (row.offsetTop < list.scrollTop + 40) list.scrollTop = row.offsetTop - 40;
    const below = row.offsetTop + row.offsetHeight - list.clientHeight;
    if (below > list.scrollTop) list.scrollTop = below;
  }
}
