// The starts and the distributions of a law and a reference, which are chosen in one place for all plots.

const choice = {law: document.getElementById('law'), family: document.getElementById('family')};
const map = document.getElementById('map');
const told = document.getElementById('told');
const buttons = [...document.querySelectorAll('.cell')];
const panels = data.figures.map((figure) => ({...figure, div: document.getElementById(`panel-${figure.column}`)}));
const FATES = {arrived: 'arrived', astray: 'did not arrive', lost: `lost: ${data.lost}`};
const SETTLING = 0; // place of the settling time among the figures
let ready = false;

const at = () => [Number(choice.law.value), Number(choice.family.value)];

function fateColour(fate) {
  return {arrived: isDark() ? '#56b4e9' : '#0072b2', astray: '#d55e00', lost: inks().ink}[fate];
}

// Where followers began ----------------------------------------------------------------------------------------------

function mapTraces(starts) {
  const leader = {
    x: [0], y: [0], mode: 'markers', hovertemplate: 'leader<extra></extra>',
    marker: {symbol: 'arrow', angle: 90, size: 20, color: inks().paper, line: {color: inks().ink, width: 1.5}},
  };
  return [...(starts ? Object.keys(FATES).map((fate) => fateTrace(starts, fate)) : []), leader];
}

function fateTrace(starts, fate) {
  const places = starts.start.map((_, place) => place).filter((place) => starts.fate[place] === fate);
  const pick = (name) => places.map((place) => starts[name][place]);
  return {
    x: pick('x'), y: pick('y'), mode: 'markers', name: fate, text: places.map((place) => about(starts, place)),
    hovertemplate: '%{text}<extra></extra>',
    marker: {
      symbol: 'arrow', angle: pick('theta').map((theta) => 90 - theta * 180 / Math.PI), size: starts.start.length > 400 ? 9 : 13,
      color: fateColour(fate), opacity: fate === 'arrived' ? 0.75 : 0.95, line: {color: inks().paper, width: 0.6},
    },
  };
}

function about(starts, place) {
  const [theta, settled, position, heading] = ['theta', 'settling_time', 'late_position', 'late_heading']
    .map((name) => starts[name][place]);
  const figure = (value, unit) => (value === null ? 'unknown' : `${Number(value.toPrecision(3))} ${unit}`);
  const end = starts.fate[place] === 'arrived' ? `settled after ${figure(settled, 's')}` : FATES[starts.fate[place]];
  return `start ${starts.start[place]}, heading ${figure(theta, 'rad')}<br>${end}<br>`
    + `late errors ${figure(position, 'm')}, ${figure(heading, 'rad')}`;
}

function mapLayout() {
  const size = [map.clientWidth - MARGIN.l - MARGIN.r, map.clientHeight - MARGIN.t - MARGIN.b];
  const metres = 2.1 * data.radius / Math.min(...size);
  const [x, y] = size.map((pixels) => [-metres * pixels / 2, metres * pixels / 2]);
  return layout(map, {
    hovermode: 'closest', dragmode: 'pan', hoverlabel: {bgcolor: inks().paper, font: {size: 11}},
    xaxis: axis({range: x, title: {text: 'x [m]', standoff: 6}}),
    yaxis: axis({range: y, title: {text: 'y [m]', standoff: 6}, scaleanchor: 'x'}),
  });
}

function writeFates(starts) {
  const items = Object.entries(FATES).map(([fate, name]) => {
    const item = document.createElement('li');
    const swatch = document.createElement('span');
    swatch.className = 'swatch';
    swatch.style.background = fateColour(fate);
    item.append(swatch, `${starts ? starts.fate.filter((each) => each === fate).length : 0} ${name}`);
    return item;
  });
  document.getElementById('fates').replaceChildren(...items);
  document.getElementById('thinned').textContent = !starts ? 'No map: not run, or over a grid.'
    : starts.start.length === starts.of ? `All ${starts.of} starts are shown.`
      : `${starts.start.length} of ${starts.of} starts are shown, those that did not arrive first.`;
}

// Distributions ------------------------------------------------------------------------------------------------------

function curveTraces(place) {
  const [chosenLaw, family] = at();
  const order = data.laws.map((_, law) => law).filter((law) => data.curves[law][family]);
  return order.sort((one, other) => (one === chosenLaw) - (other === chosenLaw)).map((law) => {
    const {x, y} = data.curves[law][family][place];
    return {
      x: [...(place === SETTLING ? [0] : x.slice(0, 1)), ...x], y: [0, ...y], mode: 'lines', name: data.laws[law].name,
      line: {
        color: data.laws[law].colour, width: law === chosenLaw ? 3 : 1.4, shape: 'hv', simplify: false,
        dash: law < 7 ? 'solid' : 'dash',
      },
      hovertemplate: '%{fullData.name}: %{y:.4g} % have at most %{x:.4g}<extra></extra>',
    };
  });
}

// A range around all values: a curve along an edge of the plot could not be seen.
function around(traces, logarithmic) {
  const values = traces.flatMap(({x}) => x).map((value) => (logarithmic ? Math.log10(value) : value));
  if (values.length === 0) return {autorange: true};
  const [low, high] = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
  const room = 0.03 * (high - low) || 0.5;
  return {range: [low - room, high + room], autorange: false};
}

function curveLayout({div, logarithmic}, traces) {
  return layout(div, {
    hovermode: 'closest', hoverlabel: {bgcolor: inks().paper, font: {size: 11}}, dragmode: 'zoom',
    xaxis: axis({
      type: logarithmic ? 'log' : 'linear', exponentformat: 'power', nticks: 6, ...around(traces, logarithmic),
    }),
    yaxis: axis({range: [-2, 104], tickvals: [0, 25, 50, 75, 100], title: {text: 'starts [%]', standoff: 4}}),
  });
}

function drawCurves(how, panel, place) {
  const traces = curveTraces(place);
  return how(panel.div, traces, curveLayout(panel, traces), PANEL_CONFIG);
}

// To work ------------------------------------------------------------------------------------------------------------

function describe() {
  const [law, family] = at();
  let count = null;
  for (const button of buttons) {
    const pressed = Number(button.dataset.law) === law && Number(button.dataset.family) === family;
    button.setAttribute('aria-pressed', pressed);
    if (pressed) [told.textContent, count] = [button.title, button.dataset.count];
  }
  const starts = data.starts[law][family];
  document.getElementById('chosen').textContent = count ? `${count} arrive` : 'not run';
  writeFates(starts);
  return starts;
}

function redraw() {
  if (!ready) return;
  Plotly.react(map, mapTraces(describe()), mapLayout(), CONFIG);
  panels.forEach((panel, place) => drawCurves(Plotly.react, panel, place));
}

function choose(law, family) {
  choice.law.value = law;
  choice.family.value = family;
  redraw();
}

async function draw() {
  await Plotly.newPlot(map, mapTraces(describe()), mapLayout(), CONFIG);
  mark('firstPlot');
  for (const [place, panel] of panels.entries()) {
    await pause();
    await drawCurves(Plotly.newPlot, panel, place);
  }
  ready = true;
  mark('ready');
}

for (const button of buttons) {
  button.addEventListener('click', () => choose(button.dataset.law, button.dataset.family));
  for (const event of ['mouseenter', 'focus']) button.addEventListener(event, () => { told.textContent = button.title; });
  for (const event of ['mouseleave', 'blur']) button.addEventListener(event, describe);
}
for (const select of Object.values(choice)) select.addEventListener('change', redraw);
watchLook(redraw);
draw();
