// All metrics over all axes, on a canvas: as SVG so many dots would take a browser seconds.

const matrix = field('dots');
const CELL = {width: 150, height: 96, left: 150, below: 34, gap: 10}; // [px]

// Places between 0 and 1, those not known NaN.
function spread(values, factors) {
  const bent = values.map((value) => (value === null ? NaN : factors ? Math.log(value) : value));
  const known = bent.filter(Number.isFinite);
  const [low, high] = [known.reduce((a, b) => Math.min(a, b), Infinity), known.reduce((a, b) => Math.max(a, b), -Infinity)];
  return bent.map((value) => (high > low ? (value - low) / (high - low) : value - low + 0.5));
}

const across = varied.map((place) => spread(columns[place], axes[place].factors));
const upwards = metrics.map(({factors}, place) => spread(rows.metrics[place], factors));
const spotAt = (line, column, row) => [
  CELL.left + column * (CELL.width + CELL.gap) + 5 + across[column][row] * (CELL.width - 10),
  line * (CELL.height + CELL.gap) + 5 + (1 - upwards[line][row]) * (CELL.height - 10),
];

function drawMatrix() {
  const [width, height] = [CELL.left + varied.length * (CELL.width + CELL.gap), metrics.length * (CELL.height + CELL.gap) + CELL.below];
  const sharp = window.devicePixelRatio || 1;
  [matrix.width, matrix.height] = [width * sharp, height * sharp];
  [matrix.style.width, matrix.style.height] = [`${width}px`, `${height}px`];
  const pen = matrix.getContext('2d');
  const {ink, grid} = inks();
  pen.scale(sharp, sharp);
  pen.font = `${LETTERS}px system-ui, sans-serif`;
  pen.textBaseline = 'middle';
  for (const [line, {name}] of metrics.entries()) {
    pen.fillStyle = ink;
    pen.fillText(name, 0, line * (CELL.height + CELL.gap) + CELL.height / 2, CELL.left - 10);
    for (const column of varied.keys()) drawPanel(pen, line, column, grid);
  }
  pen.fillStyle = ink;
  pen.textAlign = 'center';
  for (const [column, place] of varied.entries()) {
    pen.fillText(axes[place].key, CELL.left + column * (CELL.width + CELL.gap) + CELL.width / 2, height - CELL.below / 2, CELL.width);
  }
}

function drawPanel(pen, line, column, grid) {
  pen.strokeStyle = grid;
  pen.strokeRect(CELL.left + column * (CELL.width + CELL.gap), line * (CELL.height + CELL.gap), CELL.width, CELL.height);
  pen.fillStyle = accent();
  pen.globalAlpha = rows.run.length > 3000 ? 0.15 : 0.4;
  const size = rows.run.length > 3000 ? 1.5 : 2.5;
  for (const row of rows.run.keys()) {
    const [x, y] = spotAt(line, column, row);
    pen.fillRect(x - size / 2, y - size / 2, size, size); // nothing where a place is not known
  }
  pen.globalAlpha = 1;
  const [x, y] = spotAt(line, column, picked);
  pen.strokeStyle = '#d55e00';
  pen.lineWidth = 2;
  pen.beginPath();
  pen.arc(x, y, 5, 0, 2 * Math.PI);
  if (Number.isFinite(x + y)) pen.stroke();
  pen.lineWidth = 1;
}

function pickInMatrix(event) {
  const box = matrix.getBoundingClientRect();
  const [x, y] = [event.clientX - box.left, event.clientY - box.top];
  const [column, line] = [Math.floor((x - CELL.left) / (CELL.width + CELL.gap)), Math.floor(y / (CELL.height + CELL.gap))];
  if (column < 0 || column >= varied.length || line >= metrics.length) return;
  let [best, least] = [-1, Infinity];
  for (const row of rows.run.keys()) {
    const [there, up] = spotAt(line, column, row);
    const distance = (there - x) ** 2 + (up - y) ** 2;
    if (distance < least) [best, least] = [row, distance];
  }
  pick(best);
}

// To work ------------------------------------------------------------------------------------------------------------

function plots() {
  return [
    ...(maps.length ? [heat] : []), ...panels.map((panel) => () => curve(panel)), scatter, ...(indices ? [bars] : []),
  ];
}

function redraw() {
  if (!ready) return;
  tell();
  for (const plot of plots()) Plotly.react(...plot());
  drawMatrix();
}

async function draw() {
  tell();
  for (const [place, plot] of plots().entries()) {
    await pause();
    await Plotly.newPlot(...plot());
    if (place === 0) mark('firstPlot');
  }
  drawMatrix();
  if (maps.length) field('heat').on('plotly_click', pickOfCell);
  for (const {div} of panels) div.on('plotly_click', clicked);
  field('scatter').on('plotly_click', clicked);
  ready = true;
  mark('ready');
}

function choosePair(one, other) {
  [choose.one.value, choose.other.value] = [one, other];
  redraw();
}

for (const button of document.querySelectorAll('.choose')) {
  button.addEventListener('click', () => {
    choose.metric.value = button.dataset.metric;
    pick(rowOf.get(Number(button.dataset.run)));
  });
}
for (const button of document.querySelectorAll('.pair')) {
  button.addEventListener('click', () => choosePair(button.dataset.one, button.dataset.other));
}
for (const select of Object.values(choose)) select?.addEventListener('change', redraw);
[choose.one.value, choose.other.value] = pairs[0] ?? [0, Math.min(1, metrics.length - 1)];
field('copy').addEventListener('click', copy);
matrix.addEventListener('click', pickInMatrix);
watchLook(redraw);
draw();
