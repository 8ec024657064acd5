"""The browser page: a nicegui server in a thread of its own that draws what a store holds.

Drawing happens in the browser (`page.js`): the server sends it one JSON text, several times a second, and
only while there is something new. Everything is served from this machine.
"""

from __future__ import annotations

import os
import threading
from pathlib import Path

import uvicorn
from fastapi import FastAPI
from nicegui import core, ui

from soup_dashboard.door import Door
from soup_dashboard.store import Store

HOST = "127.0.0.1"
NAMES = [HOST, "localhost"]  # the page answers to no other, so that no web site can read it through the browser
REFRESH_S = 0.2
END_S = 1.5  # for the server to end by itself
FILES = Path(__file__).parent


class Server:
    """Serves the page of a store; a process can have one."""

    def __init__(self, store: Store, port: int) -> None:
        """Begin to serve what the store holds, on a TCP port of this machine."""
        os.environ["OTEL_SDK_DISABLED"] = "true"  # FastAPI would report to a collector that the environment names
        app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        app.add_middleware(Door, names=NAMES)
        core.sio.eio.cors_allowed_origins = []  # NiceGUI would give every site leave to read; this one gives none
        ui.page("/")(lambda: show(store))
        ui.run_with(
            app, title="Alphabet Soup", dark=True, tailwind=False, message_history_length=0, show_welcome_message=False
        )
        self._server = uvicorn.Server(
            uvicorn.Config(app, host=HOST, port=port, ws="wsproto", log_level="critical", timeout_graceful_shutdown=1)
        )
        self._thread = threading.Thread(target=self._server.run, name="page", daemon=True)
        self._thread.start()

    @property
    def serving(self) -> bool:
        """Whether a browser would be answered."""
        return self._server.started and self._thread.is_alive()

    @property
    def ended(self) -> bool:
        """Whether the server has ended, by itself or not."""
        return not self._thread.is_alive()

    def close(self) -> None:
        """End; browsers that look on are let go at once. Can be called twice."""
        self._server.should_exit = True
        self._thread.join(END_S)


def show(store: Store) -> None:
    """Build the page for one browser, and keep sending it what is new."""
    ui.add_css(read("page.css"))
    ui.add_body_html(f"<script>{read('page.js')}</script>")
    ui.html(read("page.html"), sanitize=False).classes("warehouse")
    client = ui.context.client
    shown = Shown()

    def refresh() -> None:
        if code := shown.news(store):
            client.run_javascript(code)

    ui.timer(REFRESH_S, refresh)


class Shown:
    """What one browser has been sent."""

    def __init__(self) -> None:
        self._run = -1
        self._revision = -1

    def news(self, store: Store) -> str:
        """The calls that bring the browser up to date; empty where it is."""
        code = ""
        if store.run != self._run:
            self._run = store.run
            code += f"warehouse.floor({store.floor()});"
        if store.revision != self._revision:
            self._revision = store.revision
            code += f"warehouse.frame({store.frame()});"
        return code


def read(name: str) -> str:
    """A file that belongs to the page."""
    return (FILES / name).read_text(encoding="utf-8")
