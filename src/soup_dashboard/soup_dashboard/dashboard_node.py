"""The dashboard's node: hears what the world tells and keeps it for the browser page."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from soup_msgs import msg

from soup_dashboard.page import HOST, Server
from soup_dashboard.store import Store
from soup_live.diagnostics import PartsWatch, Report
from soup_live.domain import stay_on_this_machine
from soup_live.process import Live, exit_status
from soup_live.qos import EVERY_ONE, LATCHED, WATCH
from soup_live.vacancies import Vacancies
from soup_msgs_py import topics
from soup_msgs_py.command_line.arguments import refuse_port_in_use
from soup_msgs_py.command_line.part_arguments import parse_dashboard
from soup_msgs_py.errors import RunError
from soup_msgs_py.wire import Announcement, from_statistics

PORT = 8080
LOOK_S = 0.2


class DashboardNode:
    """Node `/dashboard`: watches the world, asks nothing of it."""

    def __init__(self, live: Live, store: Store, server: Server) -> None:
        """Begin to listen.

        Args:
            live: The process.
            store: Where to put what the world tells.
            server: Of the page.
        """
        self._live, self._store, self._server = live, store, server
        node = live.node(topics.DASHBOARD_NODE)
        self._report = Report(live, node)
        live.follow(node, msg.Scenario, topics.SCENARIO, self._on_announcement, LATCHED)
        live.follow(node, msg.Bots, topics.BOTS, store.take_bots, WATCH)
        live.follow(node, msg.Buckets, topics.BUCKETS, store.take_buckets, WATCH)
        live.follow(node, msg.Stations, topics.STATIONS, store.take_stations, WATCH)
        live.follow(node, msg.Event, topics.EVENTS, store.take_event, EVERY_ONE)
        live.subscribe(node, msg.Statistics, topics.STATISTICS, self._on_statistics, WATCH)
        self._parts = PartsWatch(live, node)
        self._vacancies: Vacancies | None = None
        live.every(LOOK_S, self._look)

    def _on_announcement(self, announcement: Announcement) -> None:
        self._store.take_scenario(announcement.scenario, announcement.layout)
        self._vacancies = Vacancies(self._parts, announcement.scenario.bots)

    def _on_statistics(self, statistics: msg.Statistics) -> None:
        self._store.take_figures(from_statistics(statistics))

    def _look(self) -> None:
        if self._vacancies is not None:
            self._store.take_notice(self._vacancies.look())
        if self._server.ended:
            self._live.stop(RunError("the server of the page has ended"))
        elif not self._server.serving:
            self._report.waits("waits for the server of the page")
        elif not self._store.run:
            self._report.waits(f"waits for the world (nothing on {topics.SCENARIO} yet)")
        else:
            self._report.works()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the dashboard in this process; its exit status."""
    options = parse_dashboard(argv)

    def run() -> None:
        refuse_port_in_use(options.port)
        stay_on_this_machine()
        store = Store()
        with Live("dashboard") as live:
            server = Server(store, options.port)
            try:
                DashboardNode(live, store, server)
                if live.spin(lambda: server.serving or server.ended):
                    print(f"dashboard: the page is at http://{HOST}:{options.port}", flush=True)
                live.spin()
            finally:
                server.close()

    return exit_status(run)


if __name__ == "__main__":
    sys.exit(main())
