// A sweep's metrics over its axes, two of them against each other, and the run that is chosen among them.

const {axes, metrics, rows, maps, curves, fronts, pairs, again, files, indices, completed} = data;
const field = (id) => document.getElementById(id);
const choose = {metric: field('metric'), pair: field('pair'), one: field('one'), other: field('other')};
const varied = axes.map((_, place) => place).filter((place) => axes[place].varied);
const panels = varied.map((place, panel) => ({place, div: field(`curve-${panel}`)}));
const DOTS = 1500; // of a plot: a browser draws them at once
const INDICES = [['of the axis by itself', 0, '#0072b2'], ['with all that it does together with others', 2, '#e69f00']];
const SCALE = [[0, '#440154'], [0.25, '#3b528b'], [0.5, '#21918c'], [0.75, '#5ec962'], [1, '#fde725']];
const rowOf = new Map(rows.run.map((run, row) => [run, row]));
const columns = axes.map(({names, values, texts}, place) => rows.axes[place].map(
  (value) => (names ? value : values ? values[value] : Number(value))));
let ready = false;
let picked = 0;

const accent = () => (isDark() ? '#56b4e9' : '#0072b2');
const titled = ({name, unit}) => name.replaceAll('_', ' ') + (unit ? ` [${unit}]` : '');
const figure = (value, unit) => (value === null ? 'unknown' : `${Number(value.toPrecision(4))}${unit ? ` ${unit}` : ''}`);
const valueOf = (place, row) => (axes[place].texts ? axes[place].texts[rows.axes[place][row]] : rows.axes[place][row]);
const nameOf = (place, row) => (axes[place].names ? axes[place].names[rows.axes[place][row]] : String(Number(columns[place][row].toPrecision(4))));

// The chosen run -----------------------------------------------------------------------------------------------------

const quoted = (word) => (/^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`);

function command(row) {
  const held = Object.fromEntries(axes.map(({key}, place) => [key, valueOf(place, row)]));
  if (rows.seed) held.seed = rows.seed[row];
  return [again.prefix, ...again.order.map((key) => `--set ${quoted(`${key}=${held[key]}`)}`)].join(' ');
}

function row(...cells) {
  const made = document.createElement('tr');
  for (const [place, text] of cells.entries()) {
    const cell = document.createElement(place ? 'td' : 'th');
    cell.textContent = text;
    made.append(cell);
  }
  return made;
}

function tell() {
  const [metric, run] = [Number(choose.metric.value), rows.run[picked]];
  const where = axes.map(({key}, place) => `${key} = ${nameOf(place, picked)}`).join(', ');
  field('brief').textContent = `run ${run}: ${figure(rows.metrics[metric][picked], metrics[metric].unit)}`;
  field('chosen').textContent = `Run ${run}: ${where}.`;
  field('command').textContent = command(picked);
  field('copied').textContent = '';
  for (const place of document.querySelectorAll('.metric-told')) place.textContent = titled(metrics[metric]);
  const link = document.createElement('a');
  [link.href, link.textContent] = [files[run] ?? '', files[run] ?? ''];
  field('file').replaceChildren(...(files[run] ? ['Its scenario file: ', link] : []));
  field('values').replaceChildren(
    ...axes.map(({key}, place) => row(key, valueOf(place, picked))),
    ...metrics.map(({name, unit}, place) => row(name, figure(rows.metrics[place][picked], unit))),
  );
}

function pick(row) {
  if (row === undefined || row < 0) return;
  picked = row;
  redraw();
}

function clicked({points}) {
  const point = points.find(({customdata}) => typeof customdata === 'number');
  if (point) pick(point.customdata);
}

async function copy() {
  const text = field('command').textContent;
  try {
    await navigator.clipboard.writeText(text);
    field('copied').textContent = 'copied';
  } catch {
    getSelection().selectAllChildren(field('command')); // a page of a file may not write, its reader may
    field('copied').textContent = 'selected';
  }
}

// Plots --------------------------------------------------------------------------------------------------------------

// Runs with values of both, few enough: evenly among them, the chosen one as the last.
function dots(x, y) {
  const known = rows.run.map((_, row) => row).filter((row) => x[row] !== null && y[row] !== null && row !== picked);
  const every = Math.ceil(known.length / DOTS);
  const shown = known.filter((_, place) => place % every === 0);
  const all = x[picked] === null || y[picked] === null ? shown : [...shown, picked];
  const ring = all.length > shown.length;
  const spot = (of, chosen) => all.map((_, place) => (ring && place === all.length - 1 ? chosen : of));
  return {
    x: all.map((row) => x[row]), y: all.map((row) => y[row]), customdata: all, mode: 'markers', name: 'run',
    text: all.map((row) => `run ${rows.run[row]}`), hovertemplate: '%{text}: %{x:.4g}, %{y:.4g}<extra></extra>',
    marker: {
      size: spot(all.length > 400 ? 4 : 7, 11), color: spot(accent(), '#d55e00'), opacity: spot(0.4, 1),
      line: {color: inks().paper, width: spot(0, 1.5)},
    },
  };
}

const look = (div, extra) => layout(div, {hovermode: 'closest', hoverlabel: {bgcolor: inks().paper, font: {size: 11}}, ...extra});
const scale = (factors) => ({type: factors ? 'log' : 'linear', nticks: 6, exponentformat: 'power'});

function named(names) {
  const every = Math.ceil(names.length / 12);
  const places = names.map((_, place) => place).filter((place) => place % every === 0);
  return {tickvals: places, ticktext: places.map((place) => names[place])};
}

function curve({place, div}) {
  const [metric, {x, metrics: held}] = [Number(choose.metric.value), curves[place]];
  const [low, middle, high] = held[metric];
  const line = {mode: 'lines', x, hoverinfo: 'skip', line: {width: 0}, connectgaps: false};
  const ordered = !axes[place].names;
  const band = [{...line, y: low}, {...line, y: high, fill: 'tonexty', fillcolor: inks().shade}];
  const median = {
    ...line, y: middle, mode: ordered ? 'lines' : 'markers', line: {width: 2, color: inks().ink}, hoverinfo: 'all',
    marker: {symbol: 'line-ew', size: 18, line: {width: 2.5, color: inks().ink}}, hovertemplate: 'median %{y:.4g}<extra></extra>',
  };
  const shape = look(div, {
    xaxis: axis({...scale(axes[place].factors), ...(axes[place].names ? named(axes[place].names) : {})}),
    yaxis: axis({...scale(metrics[metric].factors), title: {text: metrics[metric].unit, standoff: 4}}),
  });
  return [div, [...(ordered ? band : []), dots(columns[place], rows.metrics[metric]), median], shape, PANEL_CONFIG];
}

// The runs that no other beats in both, in order of the first; of one metric with itself there is none.
function front(one, other) {
  const found = fronts.find(({metrics: pair}) => pair.includes(one) && pair.includes(other) && one !== other);
  if (!found) return {rows: [], of: 0};
  return found.metrics[0] === one ? found : {...found, rows: found.rows.toReversed()};
}

function scatter() {
  const [one, other] = [Number(choose.one.value), Number(choose.other.value)];
  const [x, y] = [rows.metrics[one], rows.metrics[other]];
  const {rows: best, of} = front(one, other);
  const told = best.length < of ? `${best.length} of the ${of} runs on the front are drawn` : `${of} on the front`;
  field('front-told').textContent = of ? told : 'choose two metrics';
  const trace = {
    x: best.map((row) => x[row]), y: best.map((row) => y[row]), customdata: best, mode: 'lines+markers',
    line: {shape: 'hv', color: '#d55e00', width: 1.5}, marker: {size: 6, color: '#d55e00'},
    text: best.map((row) => `run ${rows.run[row]}`), hovertemplate: '%{text}: %{x:.4g}, %{y:.4g}<extra></extra>',
  };
  const shape = look(field('scatter'), {
    xaxis: axis({...scale(metrics[one].factors), title: {text: titled(metrics[one]), standoff: 6}}),
    yaxis: axis({...scale(metrics[other].factors), title: {text: titled(metrics[other]), standoff: 6}}),
  });
  return [field('scatter'), [dots(x, y), trace], shape, CONFIG];
}

function bars() {
  const held = indices[Number(choose.metric.value)] ?? axes.map(() => [null, null, null, null]);
  const traces = INDICES.map(([name, at, colour]) => ({
    type: 'bar', orientation: 'h', name, y: axes.map(({key}) => key), x: held.map((each) => each[at]), marker: {color: colour},
    error_x: {type: 'data', array: held.map((each) => each[at + 1]), color: inks().ink, thickness: 1, width: 3},
    hovertemplate: '%{x:.3f}<extra>%{fullData.name}</extra>',
  }));
  const shape = look(field('bars'), {
    margin: {...MARGIN, l: 200}, showlegend: true, legend: {orientation: 'h', y: 1.12}, barmode: 'group',
    xaxis: axis({title: {text: `share of the variance of ${metrics[Number(choose.metric.value)].name}`, standoff: 6}}),
    yaxis: axis({autorange: 'reversed'}),
  });
  return [field('bars'), traces, shape, PANEL_CONFIG];
}
