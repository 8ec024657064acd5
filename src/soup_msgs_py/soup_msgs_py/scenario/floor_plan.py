"""How the floor is laid out, as a scenario says it; the modules of `soup_sim.layouts` make a `Layout` of it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from soup_msgs_py.errors import InputError
from soup_msgs_py.scenario.parameters import Cost, Count, Part, Place, Spacing
from soup_msgs_py.warehouse.cell_world import World, parse_world


class Edge(Part):
    """One more directed edge between two waypoints, or another weight for one that is there."""

    start: Place = Field(description="`[x, y]` of a waypoint, in metres")
    end: Place = Field(description="`[x, y]` of a waypoint, in metres")
    weight: Cost = Field(default=1.0, description="cost of a metre; 1 is normal")


class Highway(Part):
    """Edges along a straight line cost `weight` times as much in its direction; below 1 attracts traffic."""

    start: Place = Field(description="`[x, y]` in metres")
    end: Place = Field(description="`[x, y]` in metres")
    weight: Cost = Field(default=1.0, description="cost of a metre in its direction; 1 is normal")
    one_way: bool = Field(default=False, description="no edge leads against its direction")


class _WaypointGraph(Part):
    """What all layouts have in common; see the modules of `soup_sim.layouts`."""

    pitch_m: Spacing = Field(default=3.0, description="distance between neighbouring waypoints")
    edges: list[Edge] = Field(default=[], max_length=2_000, description="more edges, or other weights")
    highways: list[Highway] = Field(
        default=[], max_length=1_000, description="lines that are cheaper or dearer in one direction"
    )


class _Aisles(_WaypointGraph):
    """Blocks of storage spots between aisles."""

    aisle_lanes: Annotated[int, Field(ge=1, le=2)] = Field(
        default=2, description="lanes of an aisle; 2: one for each direction"
    )
    margin_columns: Annotated[int, Field(ge=1, le=50)] = Field(
        default=4, description="columns of free waypoints in front of the stations"
    )


class RowsLayout(_Aisles):
    """Rows of storage spots; every spot is next to an aisle."""

    kind: Literal["rows"] = "rows"
    block_columns: Count = Field(default=2, description="storage spots side by side between two aisles")
    block_rows: Count = Field(default=10, description="storage spots on top of each other between two cross aisles")


class DenseLayout(_Aisles):
    """Deep blocks of storage spots: inner buckets must be dug out (the tile problem)."""

    kind: Literal["dense"]
    block_columns: Count = Field(default=6, description="storage spots side by side between two aisles")
    block_rows: Count = Field(default=8, description="storage spots on top of each other between two cross aisles")


class HexagonalLayout(_Aisles):
    """Blocks of two columns, one shifted by half a pitch: round buckets packed like a honeycomb."""

    kind: Literal["hexagonal"]
    block_rows: Count = Field(default=10, description="storage spots on top of each other between two cross aisles")


class MapLayout(_WaypointGraph):
    """A floor drawn in a text file, one character a waypoint."""

    kind: Literal["map"]
    path: str = Field(description="the drawing")
    wrong_way: Annotated[float, Field(ge=1, le=1e6, allow_inf_nan=False)] | None = Field(
        default=5.0, description="how many times more a lane costs against its arrow; null forbids it"
    )


class CellsLayout(_WaypointGraph):
    """A world of cells in the notation of the 2023 paper; it says where bots and buckets begin, too."""

    kind: Literal["cells"]
    rows: Annotated[list[str], Field(min_length=1, max_length=100_000)] = Field(
        description="the rows of the world, from top to bottom"
    )

    @field_validator("rows")
    @classmethod
    def _is_a_world(cls, rows: list[str]) -> list[str]:
        try:
            parse_world("\n".join(rows))
        except InputError as error:
            where = f" ({error.key})" if error.key else ""
            raise ValueError(f"{error.found}{where}|{error.allowed}") from error
        return rows

    @property
    def world(self) -> World:
        """The world that is drawn."""
        return parse_world("\n".join(self.rows))


Layout_ = Annotated[RowsLayout | DenseLayout | HexagonalLayout | MapLayout | CellsLayout, Field(discriminator="kind")]
