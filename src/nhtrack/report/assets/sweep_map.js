// The map of a metric over two axes: of all runs, or of those with one value of the other axes.

const slices = axes.map(({key, names, texts, varied: differs}, place) => {
  const select = field('slices') && differs && texts && texts.length <= 200 ? document.createElement('select') : null;
  if (select) {
    const label = document.createElement('label');
    select.append(new Option('all', ''), ...texts.map((text, at) => new Option(names ? names[at] : text, at)));
    label.append(`${key} `, select);
    field('slices').append(label, ' ');
  }
  return {place, select};
}).filter(({select}) => select);

const held = (map) => slices.filter(({place, select}) => !map.axes.includes(place) && select.value !== '');
const inSlice = (map) => (row) => held(map).every(({place, select}) => rows.axes[place][row] === Number(select.value));

function middle(values) {
  if (values.length === 0) return null;
  values.sort((a, b) => a - b);
  const half = values.length >> 1;
  return values.length % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

// Medians of cells: those of all runs, or of the runs on the page that have the values that are held.
function cells(map, metric) {
  if (held(map).length === 0) return map.values[metric];
  const found = map.rows.map(() => map.columns.map(() => []));
  for (const row of rows.run.keys()) {
    const value = rows.metrics[metric][row];
    const [up, across] = [Math.floor(map.runs[row] / map.columns.length), map.runs[row] % map.columns.length];
    if (value !== null && inSlice(map)(row)) found[up][across].push(value);
  }
  return found.map((line) => line.map(middle));
}

// Round numbers between two powers of ten, at their logarithms.
function powers(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const every = [];
  for (let power = Math.floor(low); power <= high; power += 1) {
    for (const first of high - low < 2 ? [1, 2, 5] : [1]) every.push(Math.log10(first) + power);
  }
  const shown = every.filter((place) => place >= low - 1e-9 && place <= high + 1e-9);
  return {tickvals: shown, ticktext: shown.map((place) => String(Number((10 ** place).toPrecision(1))))};
}

// Cells stand apart where they are few: lines between many would hide them.
const gap = (cells) => (cells.length > 40 ? 0 : 1);

function heat() {
  const [map, place] = [maps[Number(choose.pair.value)], Number(choose.metric.value)];
  const {factors, unit} = metrics[place];
  const values = cells(map, place);
  const bent = values.map((line) => line.map((value) => (value === null ? null : factors ? Math.log10(value) : value)));
  const known = bent.flat().filter((value) => value !== null);
  for (const slice of slices) slice.select.parentElement.hidden = map.axes.includes(slice.place);
  const some = held(map).length && rows.run.length < completed ? 'Of the runs on this page only.' : '';
  field('map-told').textContent = known.length ? some : 'No run on this page has these values.';
  const [up, across] = map.axes.map((each) => axes[each].key);
  const trace = {
    type: 'heatmap', z: bent, colorscale: SCALE, hoverongaps: false,
    xgap: gap(map.columns), ygap: gap(map.rows),
    text: values.map((line, high) => line.map((value, wide) => `${up} ${map.rows[high]}<br>`
      + `${across} ${map.columns[wide]}<br>${figure(value, unit)}`)),
    hovertemplate: '%{text}<extra></extra>',
    colorbar: {thickness: 12, outlinewidth: 0, tickfont: {color: inks().ink, size: LETTERS}, ...(factors ? powers(known) : {})},
  };
  const shape = look(field('heat'), {
    margin: {...MARGIN, l: 90, r: 80, t: 30, b: 56},
    xaxis: axis({...named(map.columns), title: {text: across, standoff: 8}}),
    yaxis: axis({...named(map.rows), title: {text: up, standoff: 8}}),
  });
  return [field('heat'), [trace], shape, CONFIG];
}

// Of the runs of a cell the one whose value is nearest to the cell's.
function pickOfCell({points: [point]}) {
  const [map, metric] = [maps[Number(choose.pair.value)], Number(choose.metric.value)];
  const [up, across] = point.pointIndex ?? point.pointNumber;
  const value = cells(map, metric)[up][across];
  const of = rows.metrics[metric];
  const inside = [...rows.run.keys()].filter(
    (row) => map.runs[row] === up * map.columns.length + across && of[row] !== null && inSlice(map)(row));
  if (value === null || inside.length === 0) {
    field('map-told').textContent = 'No run of this cell is on the page; runs.parquet has all.';
    return;
  }
  pick(inside.reduce((best, row) => (Math.abs(of[row] - value) < Math.abs(of[best] - value) ? row : best)));
}

for (const {select} of slices) select.addEventListener('change', () => redraw());

