"""How sensors and their columns are named, everywhere: "tip" is a sensor, "tip dz" one of its columns.

A sensor of one column is meant by its name; "lever angle" with the title of the column is the same. The unit may
follow, as in the titles of tables: "tip dz [m]"; "pin force [N]" are the columns of this unit. Where a sensor bears the
name of another one's column, the sensor is meant, and the column is "tip: dz".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from flexmb.errors import did_you_mean, listed

__all__ = [
    "SensorColumn",
    "Unknown",
    "columns_named",
    "found_in",
    "not_found_in",
    "sensor_columns",
    "titles_of",
    "unknown",
    "without_unit",
]


class SensorColumn(NamedTuple):
    """A column: sensor, number of the column, its title without unit, the unit, and the name that says it."""

    sensor: str
    number: int
    component: str
    unit: str
    name: str


class Unknown(NamedTuple):
    """What an error says of a name that nothing has."""

    found: str
    expected: str
    remedy: str


def titles_of(model, sensors: Sequence[Any] | None = None) -> dict[str, tuple[str, ...]]:
    """Return the titles of the columns of a model's sensors, all or these, by sensor."""
    asked = model.sensors if sensors is None else sensors
    return {sensor.name: tuple(map(str, sensor.columns(model))) for sensor in asked}


def sensor_columns(titles: Mapping[str, Sequence[str]]) -> dict[str, tuple[SensorColumn, ...]]:
    """Return what each name means: a sensor all its columns, "sensor component" one.

    Parameters
    ----------
    titles : mapping of sensor name to titles of its columns
        With units, ("fx [N]", ...).
    """
    known: dict[str, tuple[SensorColumn, ...]] = {}
    others: dict[str, tuple[SensorColumn, ...]] = {}
    taken = set(titles)
    for sensor, own in titles.items():
        columns = []
        for number, title in enumerate(map(str, own)):
            label, _, unit = title.rpartition("[") if title.endswith("]") else (title, "", "]")
            component = label.strip()
            short = component.removeprefix(f"{sensor} ") if component != sensor or len(own) > 1 else ""
            said = (f"{sensor} {short}".strip(), f"{sensor}: {short or number}", f"{sensor}: column {number}")
            name = sensor if len(own) == 1 else next((text for text in said if text not in taken), said[-1])
            taken.add(name)
            columns.append(SensorColumn(sensor, number, component, unit[:-1].strip(), name))
            for text in (*said, f"{sensor} {component}".strip()):
                others.setdefault(text, (columns[-1],))
        known[sensor] = tuple(columns)
    named = {column.name: (column,) for columns in known.values() for column in columns}
    return {**others, **named, **known}


def columns_named(name: str, known: Mapping[str, tuple[SensorColumn, ...]]) -> tuple[SensorColumn, ...]:
    """Return the columns that a name means among those of `sensor_columns`; none if nothing has this name."""
    if name in known:
        return known[name]
    plain, unit = _with_unit(name)
    return tuple(column for column in known.get(plain, ()) if column.unit == unit)


def without_unit(name: str) -> str:
    """Return "tip dz" of "tip dz [m]"."""
    return _with_unit(name)[0]


def _with_unit(name: str) -> tuple[str, str | None]:
    """Return the name before the unit, and the unit; all of it and None without one."""
    plain, bracket, unit = name.rpartition(" [")
    return (plain.rstrip(), unit[:-1].strip()) if bracket and name.endswith("]") else (name, None)


def found_in(model, name: str) -> tuple[Any, int | None] | None:
    """Return a sensor of a model and the number of the column that the name says; None for all its columns.

    None alone if nothing has this name, or several columns but not all of them.
    """
    sensors = model.sensors_by_name
    if not isinstance(name, str) or name in sensors:
        return (sensors[name], None) if isinstance(name, str) else None
    # columns of others are not asked: they may fail
    of = [sensor for own, sensor in sensors.items() if name.startswith((f"{own} ", f"{own}: "))]
    known = sensor_columns(titles_of(model, of))
    columns = columns_named(name, known)
    if len(columns) == 1:
        return sensors[columns[0].sensor], columns[0].number
    return (sensors[columns[0].sensor], None) if columns and columns == known[columns[0].sensor] else None


def not_found_in(model, name: str) -> Unknown:
    """Return what to say of a name that `found_in` does not find: of "v x" the columns of "v", else all sensors."""
    known = [sensor.name for sensor in model.sensors]
    of = next((sensor for sensor in model.sensors if str(name).startswith(f"{sensor.name} ")), None)
    found = f"sensor '{name}' does not exist"
    if of is not None:
        own = [c.name for c in sensor_columns(titles_of(model, [of]))[of.name]]
        return Unknown(found, f"The columns of '{of.name}': {listed(name, own)}", did_you_mean(name, own))
    return Unknown(found, f"The model has: {listed(name, known) if known else 'no sensors'}", did_you_mean(name, known))


def unknown(name: str, known: Mapping[str, tuple[SensorColumn, ...]]) -> Unknown:
    """Return what to say of a name that nothing has: the columns of the sensor that it begins with, or all sensors."""
    plain, unit = _with_unit(name)
    if unit is not None and plain in known:
        units = list(dict.fromkeys(column.unit for column in known[plain]))
        return Unknown(
            f"the unit [{unit}] of '{plain}'",
            " or ".join(f"[{own}]" if own else "no unit" for own in units) + ": values of sensors are not converted",
            f"Write '{plain}'",
        )
    sensors = list(dict.fromkeys(column.sensor for columns in known.values() for column in columns))
    of = max((sensor for sensor in sensors if name == sensor or name.startswith(f"{sensor} ")), key=len, default=None)
    offered = [column.name for column in known[of]] if of is not None else sensors
    near = did_you_mean(name, [*sensors, *(column.name for columns in known.values() for column in columns)])
    return Unknown(
        f"there is no sensor or component '{name}'",
        f"One of: {listed(name, offered)}" if offered else "a model with sensors",
        near or "Components follow the name of the sensor: 'strut force fx'",
    )
