"""The pages in headless Chromium: no message in the console, nothing wider than the window, every figure drawn."""

from __future__ import annotations

from pathlib import Path

import pytest

from .browser import chromium, look_at
from .runs import MAKERS

pytestmark = pytest.mark.skipif(chromium() is None, reason="needs Chromium: apt-get install chromium")
WIDTHS = (360, 1200)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", MAKERS)
def test_page_in_a_browser(reports, tmp_path: Path, name: str, width: int) -> None:
    report = reports(name)
    seen = look_at(report.path, tmp_path, width)
    assert seen.console == []
    page = seen.page
    assert page["client"] == width
    assert page["scroll"] <= page["client"]
    assert page["wide"] == []
    assert page["scripts"] == 0
    assert set(page["figures"]) == {part.split('"')[0] for part in report.html.split('<figure id="')[1:]}
    for figure, found in page["figures"].items():
        assert found["width"] > 0.4 * min(width, 760), figure
        assert found["height"] > 100, figure
        assert found["drawn"] > 5, figure
        assert found["outside"] == 0, figure
        assert found["smallest"] >= 9, figure  # letters on a phone
    for picture in ("last", "start"):
        if picture in page["figures"]:
            assert page["figures"][picture]["images"] == 1
    for one in report.findings:
        if one.level == "warning":
            assert one.text.split("`")[0] in page["text"]


def test_the_browser_notices_what_is_wrong(reports, tmp_path: Path) -> None:
    """A page that is too wide, loads from elsewhere although it may not, and lacks a figure's content."""
    bad = tmp_path / "bad.html"
    html = reports("empty").html
    wrong = (
        '<p style="width:900px">wide</p><img src="https://example.org/x.png"><figure id="f"><svg></svg></figure></body>'
    )
    bad.write_text(html.replace("</body>", wrong), encoding="utf-8")
    seen = look_at(bad, tmp_path, 360)
    assert seen.page["scroll"] > seen.page["client"]
    assert any("wide" in one for one in seen.page["wide"])
    assert any("Content Security Policy" in line for line in seen.console)
    assert seen.page["figures"]["f"]["drawn"] == 0
