// The checks of one robot or of all, in the order of measuring or the nearest to their budgets first.

const robot = document.getElementById('robot');
const bodies = [...document.querySelectorAll('.checks tbody')].map((body) => ({body, rows: [...body.rows]}));

function arrange() {
  const byUse = chosen('order', 'listed') === 'used';
  for (const {body, rows} of bodies) {
    const order = byUse ? rows.toSorted((one, other) => other.dataset.used - one.dataset.used) : rows;
    body.append(...order);
    for (const row of rows) row.hidden = robot.value !== '' && row.dataset.robot !== robot.value;
  }
}

robot.addEventListener('change', arrange);
document.getElementById('order').addEventListener('change', arrange);
watchLook(() => {});
mark('firstPlot');
mark('ready');
