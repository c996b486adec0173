"""The notebooks run from beginning to end, are kept without outputs, and every result in them shows itself."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))
# What the results of the tour show, in its order.
SHOWN = ("universal", "followers settled", "slip", "slipping", "video/mp4", "samson", "gains of the my_law law",
         "Does not fit", "motion limits", "Starts that arrive")  # fmt: skip


@pytest.mark.parametrize("path", NOTEBOOKS, ids=[path.name for path in NOTEBOOKS])
def test_notebooks_are_kept_without_outputs(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in notebook.cells)


@pytest.mark.slow
@pytest.mark.render
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of the kernel's client
def test_the_tour_runs(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOKS[0], as_version=4)
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    outputs = [output for cell in code for output in cell.outputs]
    assert not [output for output in outputs if output.output_type == "stream" and output.name == "stderr"]
    pages = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    views = [page for page in pages if 'class="nhtrack"' in page]
    assert len(views) == len(SHOWN)
    for view, words in zip(views, SHOWN, strict=True):
        assert words in view
    assert "No pictures" not in "".join(views)
    assert "did you mean 'kanayama'" in outputs[-1].text
