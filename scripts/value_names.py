"""Names of the values in messages, as the page of the messages shows them."""

from __future__ import annotations

import re

# The unit at the end of a name; the sentence has it too.
UNIT = re.compile(r"_(m|mm|cm|um|s|ms|us|ns|k?hz|mhz|ghz|deg|db|v|mb|gb|mib|gib|mm_s)$")

# Name: in English, what it means; in Spanish, what it means. Without a meaning it is plain.
NAMES = {
    "count": ("number", "", "número", ""),
    "reason": ("reason", "another message of this page", "motivo", "otro mensaje de esta página"),
    "file": ("file", "", "archivo", ""),
    "path": ("file", "", "archivo", ""),
    "folder": ("folder", "", "carpeta", ""),
    "axis": ("axis", "x, y or z", "eje", "x, y o z"),
    "name": ("name", "", "nombre", ""),
    "index": (
        "index",
        "number of a trace in the plan, from 0",
        "índice",
        "número de traza, desde 0",
    ),
    "unit": (
        "unit",
        "mm on X and Y, deg on Z, or its own",
        "unidad",
        "mm en X e Y, grados en Z, o la suya",
    ),
    "age": ("age", "", "antigüedad", ""),
    "longest": ("longest", "", "máximo", ""),
    "sensor": ("sensor", "", "sensor", ""),
    "topic": ("topic", "", "tópico", ""),
    "fields": ("fields", "", "campos", ""),
    "survey": ("survey", "its name or folder", "campaña", "su nombre o carpeta"),
    "limit": ("limit", "", "límite", ""),
    "most": ("most", "the largest allowed value", "máximo", "el mayor valor permitido"),
    "least": ("least", "the smallest allowed value", "mínimo", "el menor valor permitido"),
    "fewest": ("fewest", "the smallest allowed number", "mínimo", "el menor número permitido"),
    "upper": ("upper", "the largest allowed value", "superior", "el mayor valor permitido"),
    "lower": ("lower", "the smallest allowed value", "inferior", "el menor valor permitido"),
    "highest": ("highest", "the largest allowed value", "mayor", "el mayor valor permitido"),
    "lowest": ("lowest", "the smallest allowed value", "menor", "el menor valor permitido"),
    "high": ("high", "the largest allowed value", "superior", "el mayor valor permitido"),
    "low": ("low", "the smallest allowed value", "inferior", "el menor valor permitido"),
    "total": ("total", "", "total", ""),
    "value": ("value", "", "valor", ""),
    "address": ("address", "of the network analyzer", "dirección", "del analizador"),
    "points": ("points", "frequencies of a sweep", "puntos", "frecuencias de un barrido"),
    "time": ("time", "", "hora", ""),
    "permittivity": ("permittivity", "", "permitividad", ""),
    "planned": ("planned", "number in the plan", "previstas", "número en el plan"),
    "stored": ("stored", "number on the disk", "almacenadas", "número en el disco"),
    "allowed": ("allowed", "list of what is possible", "permitidos", "lista de lo posible"),
    "found": ("found", "what was there instead", "encontrado", "lo que había en su lugar"),
    "expected": ("expected", "what should be there", "esperado", "lo que debería haber"),
    "coordinate": ("coordinate", "", "coordenada", ""),
    "target": ("target", "", "destino", ""),
    "identity": (
        "identity",
        "maker, model and serial number",
        "identidad",
        "fabricante, modelo, serie",
    ),
    "command": ("command", "to type in a terminal", "orden", "que se escribe en una terminal"),
    "what": ("what", "", "qué", ""),
    "state": ("state", "", "estado", ""),
    "node": ("node", "a part of the software", "nodo", "una parte del programa"),
    "device": ("device", "", "dispositivo", ""),
    "traces": ("traces", "", "trazas", ""),
    "trace": ("trace", "", "traza", ""),
    "key": ("key", "name of a setting in a file", "clave", "nombre de un ajuste en un archivo"),
    "step": ("step", "", "paso", ""),
    "distance": ("distance", "", "distancia", ""),
    "height": ("height", "", "altura", ""),
    "depth": ("depth", "", "profundidad", ""),
    "free": ("free", "", "libres", ""),
    "needed": ("needed", "", "necesarios", ""),
    "former": ("former", "the value before", "anterior", "el valor de antes"),
    "wanted": ("wanted", "the value of the plan", "deseado", "el valor del plan"),
    "accepted": ("accepted", "what the analyzer set", "aceptado", "lo que fijó el analizador"),
}


def shown_name(field: str, language: str) -> str:
    """Return the words for a value.

    Args:
        field: Its name in the template, such as `free_mb`.
        language: `en` or `es`.
    """
    name = UNIT.sub("", field)
    return NAMES.get(name, (name,) * 4)[0 if language == "en" else 2].replace("_", " ")
