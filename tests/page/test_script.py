"""What the script of a served page asks the server for, in Node without a browser."""

from __future__ import annotations

import json
import re
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.marks import marked, one_then
from support.pictures import sweep

pytest.importorskip("bokeh", reason="bokeh is not installed")
pytest.importorskip("playwright", reason="playwright is not installed")
import playwright

from sweeps.page.document import MODULES, served
from sweeps.page.subject import Subject, subject_of_paper

NODE = Path(playwright.__file__).parent / "driver" / "node"
FOLDER = Path(__file__).parents[2] / "sweeps" / "page" / "web"
# The parts of a browser that the script needs as it begins, and all that it draws.
BROWSER = """
const made = {};
const part = (id) => made[id] ??= { id, options: [], querySelectorAll: () => [] };
part("data").textContent = DATA;
const document = { getElementById: part };
const named = (name) => ({ data: { values: VALUES[name] } });
const Bokeh = { documents: [{ get_model_by_name: named }] };
const crypto = { getRandomValues: (numbers) => numbers };
"""
DRAWS_NOTHING = "draw = remember = showControls = drawMotion = showCopies = () => {};"
ASKS = "const requests = []; ask = (parts) => { requests.push(parts); state.wanted = parts; };"


def told(subject: Subject, script: str, values: dict[str, list[float]] | None = None) -> Any:
    """Return what an expression in the scope of the script gives; `values` lie along axes."""
    if not NODE.exists():
        pytest.skip("the Node of playwright is not there")
    page = served(subject).decode()
    found = re.search(r'type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    along = {f"values of {name}": numbers for name, numbers in (values or {}).items()}
    given = f"const DATA = {json.dumps(found[1])}, VALUES = {json.dumps(along)};"
    modules = [(FOLDER / f"{name}.js").read_text("utf-8") for name in MODULES[:-1]]
    text = "\n".join([given, BROWSER, *modules, DRAWS_NOTHING, ASKS, script])
    done = subprocess.run([NODE, "-"], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_another_law_is_asked_for_without_the_identity_of_the_last_one():
    """A built-in law with that identity would be refused."""
    film = '"film.friction": "limited", "film.law": "its-package-1.0+00"'
    script = f"""
        state.wanted = {{ temperature: "250", {film}, "film.strain": "relaxing" }};
        choose("film.friction", "power-law");
        console.log(JSON.stringify(requests));
    """
    law = {"film.friction": "power-law", "film.strain": "relaxing"}
    assert told(subject_of_paper(), script) == [{"temperature": "250", **law}]


@pytest.mark.parametrize("is_of_file", one_then("stress", [True, False]))
def test_the_open_point_of_the_file_moves_with_the_slice(is_of_file: bool):
    """Otherwise its mark and its numbers would be at a point that is not open."""
    axes = {"temperature": [200.0, 250.0], "spring_stiffness": [500.0, 1000.0]}
    axes |= {"rheological_index": [-0.5, 0.5]}
    result = sweep(**axes).assign_attrs(config="{}")
    subject = replace(subject_of_paper(), result=result)
    script = f"""
        state.place = [1, 0, 0];
        state.pinned = {str(is_of_file).lower()};
        inputs.push({{ value: "1" }}, {{ value: "0" }}, {{ value: "1" }});
        read({{ target: {{ type: "range" }} }});
        console.log(JSON.stringify([state.place, requests]));
    """
    place, requests = told(subject, script, axes)
    assert place == [1, 0, 1]
    there = {"at.temperature": "250", "at.spring_stiffness": "500", "at.rheological_index": "0.5"}
    assert requests == ([there] if is_of_file else [])


@pytest.mark.parametrize("waiting", one_then("stress", ["null", "{}"]))
def test_an_answer_leaves_the_pin_where_a_key_has_moved_it_meanwhile(waiting: str):
    """Otherwise the next key would move it from a point that it has left."""
    axes = {"temperature": [200.0, 210.0, 220.0], "spring_stiffness": [500.0, 1000.0]}
    result = sweep(**axes).assign_attrs(config="{}")
    subject = replace(subject_of_paper(), result=result)
    script = f"""
        state.place = [2, 0];
        state.pinned = true;
        next = {waiting};
        const at = {{ "at.temperature": "210", "at.spring_stiffness": "500" }};
        showAnswer({{ courses: null, at }});
        console.log(JSON.stringify(state.place));
    """
    assert told(subject, script, axes) == ([1, 0] if waiting == "null" else [2, 0])


@pytest.mark.parametrize("show", one_then("stress", ["showRefusal", "showRefusedAddress"]))
def test_after_a_refusal_the_pin_is_at_the_open_point(show: str):
    """Otherwise the address of the page would open another one."""
    axes = {"temperature": [200.0, 210.0, 220.0], "spring_stiffness": [500.0, 1000.0]}
    result = sweep(**axes).assign_attrs(config="{}")
    subject = replace(subject_of_paper(), result=result)
    script = f"""
        state.opened = {{ ...live.first, parts: {{ temperature: "210" }} }};
        state.opened.at = {{ "at.temperature": "210", "at.spring_stiffness": "500" }};
        state.place = [0, 1];
        complain = () => {{}};
        showRefusals = () => {{}};
        {show}({{ refused: {{ temperature: "too cold" }}, parts: {{ temperature: "-5" }} }});
        console.log(JSON.stringify([state.pinned, state.place, requests]));
    """
    assert told(subject, script, axes) == [True, [1, 0], []]


@pytest.mark.parametrize(("meltings", "height"), [(4, 0), (2, None)])
def test_the_kind_of_an_open_point_is_marked_at_its_place(meltings: int, height: int | None):
    """All points of the file have four meltings, so no other number is on the axis."""
    subject = replace(
        subject_of_paper(), result=sweep(temperature=[200.0, 210.0]).assign_attrs(config="{}")
    )
    script = f"""
        state.variable = variables.find(({{ name }}) => name === "melting_count");
        const shown = {{ temperature: 250, melting_count: {meltings} }};
        const [, y] = spotOfOpened({{ kind: "cloud", names: ["temperature", ""] }}, {{ shown }});
        console.log(JSON.stringify(y));
    """
    assert told(subject, script) == height


@pytest.mark.parametrize(
    ("written", "opened"),
    [
        ({"at.temperature": "219"}, {"at.temperature": "220", "at.spring_stiffness": "500"}),
        *marked("stress", [({"at.temperature": "219", "at.bogus": "1"}, None), ({}, None)]),
    ],
)
def test_a_place_in_an_address_is_opened(written: dict[str, str], opened: dict[str, str] | None):
    """As in a report, even if the address does not say that it is pinned."""
    axes = {"temperature": [200.0, 210.0, 220.0], "spring_stiffness": [500.0, 1000.0]}
    result = sweep(**axes).assign_attrs(config="{}")
    script = f"""
        const first = () => JSON.stringify(requests[0]) === JSON.stringify(firstParts());
        page.start = [0, 0];
        open(readPoint(Object.entries({json.dumps(written)}), startPlace()), null);
        console.log(JSON.stringify(first() ? null : requests[0]));
    """
    assert told(replace(subject_of_paper(), result=result), script, axes) == opened


def test_a_name_that_no_result_of_a_stack_has_is_nowhere():
    """Even if the names look like numbers, it is not taken for the nearest one."""
    script = """
        axes.push({ name: "film", called: ["film"], size: 2 });
        parameters.push({ name: "film", keys: ["1", "2"] });
        console.log(JSON.stringify(["1", "2", "3"].map((text) => placeAlong(0, text) ?? null)));
    """
    assert told(subject_of_paper(), script) == [0, 1, None]


def test_a_command_quotes_the_name_of_a_result_in_a_stack():
    script = """console.log(JSON.stringify(["film=a", "film=it's <b>"].map(quoted)));"""
    assert told(subject_of_paper(), script) == ["film=a", """'film=it'"'"'s &lt;b&gt;'"""]


def test_a_zoom_of_an_address_holds_when_points_are_drawn():
    """Bokeh fits the ranges of points to them, unless it knows of a zoom."""
    script = """
        const ends = (low, high) => ({
          setv({ start, end }) { [low, high] = [start, end]; },
          drawn() { return this.have_updated_interactively ? [low, high] : "all points"; },
        });
        const figure = { x_range: ends(), y_range: ends() };
        zoomTo(figure, [210, 220, 0, 5]);
        console.log(JSON.stringify(Object.values(figure).map((range) => range.drawn())));
    """
    assert told(subject_of_paper(), script) == [[210, 220], [0, 5]]


PICTURE = """
    const range = () => ({
      setv(ends) { Object.assign(this, ends); },
      reset() { Object.assign(this, { start: "first", end: "last" }); },
    });
    const figure = { renderers: [], right: [], left: [{}], x_range: range(), y_range: range() };
    models.set(state.view.linear.figure, figure);
    for (const scale of ["linear", "log"]) models.set(`colours ${scale}`, { setv() {} });
    Bokeh.documents[0].roots = () => page.hosts.map(() => ({ children: [figure] }));
    FILL.curves = () => {};
    const ends = () => [figure.x_range, figure.y_range].map(({ start, end }) => [start, end]);
    draw = () => show(state.view.linear, "picture", state.place);
    Object.assign(state, { zoom: [210, 220, 0, 5], variable: variables[0] });
"""


@pytest.fixture
def curves() -> Subject:
    result = sweep(temperature=[200.0 + i for i in range(30)]).assign_attrs(config="{}")
    return replace(subject_of_paper(), result=result)


def test_curves_that_are_drawn_again_stay_zoomed(curves: Subject):
    """Otherwise a click would show a different part from the one in the address."""
    script = f"{PICTURE} draw(); console.log(JSON.stringify(ends()));"
    assert told(curves, script) == [[210, 220], [0, 5]]


def test_another_variable_on_the_vertical_axis_is_not_zoomed(curves: Subject):
    """Otherwise the address would open it with the range of the last one, mostly empty."""
    script = f"""
        {PICTURE} draw();
        Object.assign(element("view"), {{ selectedIndex: 0 }});
        Object.assign(element("variable"), {{ selectedIndex: 1 }});
        read({{ target: {{ id: "log" }} }});
        console.log(JSON.stringify([state.zoom, ends()]));
    """
    assert told(curves, script) == [None, [["first", "last"]] * 2]
