// What every page does: light and dark, screen and paper, the look of plots.

const data = JSON.parse(document.getElementById('data').textContent);

const MARGIN = {l: 54, r: 12, t: 8, b: 38}; // [px] fixed, so that a place on the plot is known without asking Plotly
const [LETTERS, TITLES] = [11, 12]; // [px] of numbers at an axis, and of what it is called
const POWERS = LETTERS / 1.25; // Plotly draws numbers at logarithmic axes larger than it is told
const INKS = {
  light: {ink: '#1a1a1a', soft: '#5c5c5c', grid: '#e4e4e4', paper: '#ffffff', shade: 'rgba(122,122,122,0.16)'},
  dark: {ink: '#e6e6e6', soft: '#a6a6a6', grid: '#33373c', paper: '#16181b', shade: 'rgba(200,200,200,0.14)'},
};
// The page follows the window by itself, since overlays have to. Panels have no buttons: they zoom by dragging, and the
// way from one to the next with the tab key stays short.
// Buttons are those named here and no others, whatever Plotly comes to have: none sends anything anywhere.
const BUTTONS = [['toImage'], ['zoom2d', 'pan2d'], ['zoomIn2d', 'zoomOut2d', 'resetScale2d']];
const CONFIG = {displaylogo: false, responsive: false, plotlyServerURL: '', showSendToCloud: false, modeBarButtons: BUTTONS};
const PANEL_CONFIG = {...CONFIG, displayModeBar: false};

function isDark() {
  const root = document.documentElement;
  if (root.classList.contains('printing')) return false;
  return (root.dataset.theme ?? (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light')) === 'dark';
}

function inks() {
  return INKS[isDark() ? 'dark' : 'light'];
}

function axis(extra) {
  const {ink, soft, grid} = inks();
  return {
    gridcolor: grid, linecolor: soft, tickcolor: soft, tickfont: {color: ink, size: extra.type === 'log' ? POWERS : LETTERS},
    zeroline: false, showline: true, ticks: 'outside', ticklen: 3, automargin: false,
    // Neither turned nor left out for want of room: Plotly would measure every label anew for that, twice a plot.
    tickangle: 0, ticklabeloverflow: 'allow', ...extra, title: {font: {size: TITLES}, ...extra.title},
  };
}

function layout(div, extra) {
  const {ink, soft} = inks();
  return {
    width: div.clientWidth, height: div.clientHeight, margin: MARGIN, showlegend: false,
    paper_bgcolor: 'rgba(0,0,0,0)', plot_bgcolor: 'rgba(0,0,0,0)',
    font: {family: 'system-ui, sans-serif', size: 12, color: ink},
    modebar: {bgcolor: 'rgba(0,0,0,0)', color: soft, activecolor: ink}, ...extra,
  };
}

function chosen(name, otherwise) {
  return document.querySelector(`input[name="${name}"]:checked`)?.value ?? otherwise;
}

// A task of its own for each plot, when the browser has nothing else to do: the page answers while they are being drawn.
const whenIdle = window.requestIdleCallback ? (work) => requestIdleCallback(work, {timeout: 200}) : setTimeout;
const pause = () => new Promise((resolve) => whenIdle(() => resolve()));

// Says when a page began to be of use, and when all of it was there [ms].
function mark(name) {
  document.documentElement.dataset[name] = Math.round(performance.now());
}

// Has everything drawn anew when colours or sizes change.
function watchLook(redraw) {
  const root = document.documentElement;
  const print = (printing) => {
    root.classList.toggle('printing', printing);
    redraw();
  };
  document.getElementById('theme').addEventListener('click', () => {
    root.dataset.theme = isDark() ? 'light' : 'dark';
    redraw();
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  matchMedia('print').addEventListener('change', ({matches}) => print(matches));
  let waiting = null;
  window.addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(redraw, 150);
  });
}
