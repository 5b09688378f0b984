"""The file around the numbers: style, script, plotly.js, data."""
from __future__ import annotations

import base64
import html
import json
import pathlib

from amb_rotor.cli import common

_HERE = pathlib.Path(__file__).resolve().parent


def embedded(value) -> str:
    """JSON that may stand inside a script element."""
    return json.dumps(common._plain(value), allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def _pictures(pictures) -> str:
    figures = []
    for path, caption in pictures:
        content = base64.b64encode(pathlib.Path(path).read_bytes()).decode()
        figures.append(f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{content}">'
                       f"<figcaption>{html.escape(caption)}</figcaption></figure>")
    if not figures:
        return ""
    return '<section id="motion"><h2>The motion</h2><div class="pictures">' + "".join(figures) + "</div></section>"


def report_text(title: str, subtitle: str, stages: list[dict], diagnosis: dict | None = None,
                revisions: list[dict] | None = None, pictures=(), notes=(), tables=(), law=()) -> str:
    """The whole page. stages: data.stage() of each model that was compared, the first one first; pictures: (path of a
    PNG, caption); notes: sentences of the first page; tables: {title, columns, rows}; law: law.law_curves()."""
    from plotly.offline import get_plotlyjs
    data = {"title": title, "subtitle": subtitle, "stages": stages, "diagnosis": diagnosis,
            "revisions": revisions or [], "notes": list(notes), "tables": list(tables), "law": list(law)}
    parts = {"@TITLE@": html.escape(title), "@STYLE@": (_HERE / "report.css").read_text(),
             "@PICTURES@": _pictures(pictures), "@DATA@": embedded(data),
             "@SCRIPT@": (_HERE / "report.js").read_text(), "@PLOTLY@": get_plotlyjs()}
    text = (_HERE / "report.html").read_text()
    for mark, part in parts.items():
        text = text.replace(mark, part, 1)
    return text


def write_report(path, title: str, subtitle: str, stages: list[dict], diagnosis: dict | None = None,
                 revisions: list[dict] | None = None, **more) -> pathlib.Path:
    common.atomic_write(path, report_text(title, subtitle, stages, diagnosis, revisions, **more))
    return pathlib.Path(path)
