"""Each notebook runs from its first cell to its last, and what it prints and keeps is fit to be read."""

import re
import shutil
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpec
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
LARGEST = 1.5e6
"""Bytes of a notebook with its pictures."""
SECONDS = 600
"""For one cell, on a busy machine."""


class ThisPython(AsyncKernelManager):
    """The kernel is the Python that runs the tests, whether or not it is registered with Jupyter."""

    @property
    def kernel_spec(self):
        return KernelSpec(
            argv=[sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"], language="python"
        )


def executed(path: Path, folder: Path, monkeypatch):
    """The notebook after a run in a copy of its surroundings; raises `CellExecutionError` at the first error."""
    for part in ("notebooks", "examples"):
        shutil.copytree(ROOT / part, folder / part)
    for variable in ("IPYTHONDIR", "JUPYTER_RUNTIME_DIR", "MPLCONFIGDIR"):
        monkeypatch.setenv(variable, str(folder / variable))
    notebook = nbformat.read(folder / "notebooks" / path.name, as_version=4)
    resources = {"metadata": {"path": str(folder / "notebooks")}}
    return NotebookClient(notebook, kernel_manager_class=ThisPython, timeout=SECONDS, resources=resources).execute()


def outputs(notebook):
    return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]


def words(output) -> str:
    """All that an output says in words."""
    if output.output_type == "error":
        return "\n".join(["Traceback", *output.traceback])
    if output.output_type == "stream":
        return output.text
    return "\n".join(text for kind, text in output.data.items() if kind.startswith("text/"))


def check_outputs(notebook):
    for output in outputs(notebook):
        assert output.get("name") != "stderr", f"written to the error stream: {output.text}"
        assert not re.search(r"traceback|\bwarning|\w+Warning\b|\w+Error\b", words(output), re.IGNORECASE), words(
            output
        )
    assert any("image/png" in output.get("data", {}) for output in outputs(notebook)), "there is no picture"


def test_all_notebooks_are_there():
    assert [path.name for path in NOTEBOOKS] == [
        "1_how_a_ray_becomes_a_pixel.ipynb",
        "2_how_a_picture_becomes_coefficients.ipynb",
        "3_why_edges_matter.ipynb",
        "4_what_accuracy_costs.ipynb",
        "5_a_photograph.ipynb",
        "6_what_can_a_picture_tell.ipynb",
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_runs(path, tmp_path, monkeypatch):
    check_outputs(executed(path, tmp_path, monkeypatch))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_is_kept_with_clean_outputs(path):
    text = path.read_text(encoding="utf-8")
    notebook = nbformat.reads(text, as_version=4)
    nbformat.validate(notebook)
    check_outputs(notebook)
    assert all(cell.execution_count for cell in notebook.cells if cell.cell_type == "code"), "a cell was not run"
    assert len(text) < LARGEST
    said = "\n".join(map(words, outputs(notebook))) + str(notebook.metadata)
    assert not re.search(r"(/|\\)(home|root|Users|tmp|work|usr|opt)\b", said), "a path of somebody's machine"


def test_a_warning_or_an_error_does_not_pass(tmp_path, monkeypatch):
    cell = nbformat.v4.new_code_cell
    clean = cell(outputs=[nbformat.v4.new_output("display_data", {"image/png": ""})])
    told = cell(outputs=[nbformat.v4.new_output("stream", name="stdout", text="UserWarning: old")])
    failed = cell(
        outputs=[nbformat.v4.new_output("error", ename="ValueError", evalue="no", traceback=["ValueError: no"])]
    )
    check_outputs(nbformat.v4.new_notebook(cells=[clean]))
    for bad in (told, failed):
        with pytest.raises(AssertionError):
            check_outputs(nbformat.v4.new_notebook(cells=[clean, bad]))
