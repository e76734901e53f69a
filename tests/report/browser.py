"""A page in headless Chromium: what its console says, whether it fits into a window, and a picture of it.

The page itself has no script. It is shown in a frame of the wanted width inside a wrapper of ours, whose script looks
at the frame; Chromium's own smallest width of a window does not matter so.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage"),
    *("--allow-file-access-from-files", "--enable-logging=stderr", "--v=0", "--virtual-time-budget=8000"),
)
_WRAPPER = """<!DOCTYPE html><html><head><link rel="icon" href="data:,"></head><body style="margin:0">
<iframe id="page" src="{url}" style="border:0;width:{width}px;height:{height}px"></iframe><pre id="told"></pre>
<script>
window.addEventListener("load", () => {{
  const frame = document.getElementById("page"), page = frame.contentDocument, root = page.documentElement;
  const own = element => {{ for (let e = element; e; e = e.parentElement)
    if (e !== root && ["auto", "scroll"].includes(frame.contentWindow.getComputedStyle(e).overflowX)) return true;
    return false; }};
  const wide = [...page.querySelectorAll("body *")].filter(e => !own(e) && !e.closest("svg") &&
    e.getBoundingClientRect().right > root.clientWidth + 1).map(e => e.tagName + " " + e.textContent.slice(0, 60));
  const figures = Object.fromEntries([...page.querySelectorAll("figure")].map(f => {{
    const svg = f.querySelector("svg"), box = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll("text")], letters = texts.map(t => t.getBoundingClientRect());
    const high = (t, b) => t.textContent.trim().length > 2 ? b.height : Math.max(b.height, b.width); // may be turned
    return [f.id, {{ width: box.width, height: box.height, drawn: svg.querySelectorAll("path, image, use").length,
      images: svg.querySelectorAll("image").length, label: svg.getAttribute("aria-label"),
      smallest: Math.min(...texts.map((t, k) => high(t, letters[k]))),
      outside: letters.filter(b => b.left < box.left - 3 || b.right > box.right + 3).length }}]; }}));
  document.getElementById("told").textContent = JSON.stringify({{ scroll: root.scrollWidth, client: root.clientWidth,
    height: root.scrollHeight, text: page.body.innerText, scripts: page.querySelectorAll("script").length,
    wide, figures }});
}});
</script></body></html>
"""


@dataclass(frozen=True)
class Seen:
    """What the browser made of a page: ``console`` holds its messages, ``page`` what the wrapper's script found."""

    console: list[str]
    page: dict[str, Any]


def chromium() -> str | None:
    """The browser, None when there is none."""
    return next(
        (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
    )


def look_at(path: Path, folder: Path, width: int, picture: Path | None = None, height: int = 900) -> Seen:
    """Open a page in a frame of this width; take a picture of it when asked to."""
    wrapper = folder / f"wrapper-{width}.html"
    wrapper.write_text(_WRAPPER.format(url=path.resolve().as_uri(), width=width, height=height), encoding="utf-8")
    done = _run(folder, "--dump-dom", wrapper.as_uri())
    told = re.search(r'<pre id="told">(.*?)</pre>', done.stdout, re.DOTALL)
    assert told is not None, done.stderr
    assert told[1], done.stderr
    text = told[1].replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", " ").replace("&amp;", "&")
    if picture is not None:
        size = f"--window-size={width},{height}"
        _run(folder, f"--screenshot={picture}", size, "--force-device-scale-factor=1", wrapper.as_uri())
    return Seen([line for line in done.stderr.splitlines() if "CONSOLE" in line], json.loads(text))


def _run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    browser = chromium()
    assert browser is not None
    command = [browser, *_FLAGS, f"--user-data-dir={folder / 'profile'}", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
