"""Files of other instruments, written by their documented headers."""

import struct

import h5py
import numpy as np
from obspy.io.segy.pack import pack_4byte_ibm

from gpr20_analysis.formats.imports import IMPORTS, Band, ImportOptions
from gpr20_analysis.work import no_progress

TRACES, SAMPLES, SPACING_M, WINDOW_NS = 6, 40, 0.02, 8.0
RICKER = ("--source", "ricker:1.5e9")


def counts(bits=16, traces=TRACES, samples=SAMPLES, seed=1):
    """Return signed samples, the first three of a trace equal as after the marks of a DZT."""
    random = np.random.default_rng(seed)
    found = random.integers(-(2 ** (bits - 2)), 2 ** (bits - 2), (traces, samples))
    found[:, :2] = found[:, 2:3]
    return found


def channel_header(samples=SAMPLES, bits=16, channels=1, antenna=b"1.5/1.6GH", gains=(), **more):
    """Return the header of a channel of a DZT file."""
    header = bytearray(1024)
    values = {"tag": 0xFF, "data": channels, "spm": 1.0 / SPACING_M, "position": 0.0}
    values.update({"range": WINDOW_NS, "epsr": 6.0, **more})
    zero = {8: 0x80, 16: -0x8000, 32: 0}[bits]
    struct.pack_into("<4Hh", header, 0, values["tag"], values["data"], samples, bits, zero)
    struct.pack_into(
        "<5f", header, 10, 100.0, values["spm"], 0.0, values["position"], values["range"]
    )
    struct.pack_into("<Hf", header, 52, channels, values["epsr"])
    header[98 : 98 + len(antenna)] = antenna
    if gains:
        struct.pack_into("<H", header, 40, 128)
        struct.pack_into(f"<H{len(gains)}f", header, 128, len(gains), *gains)
    return bytes(header)


def write_dzt(path, channels=None, bits=16, second=None, **more):
    """Write (trace, sample) counts of each channel; marks stand in the first two samples.

    `second` is what differs in the header of the second channel.
    """
    channels = [counts(bits)] if channels is None else channels
    values = np.stack(channels, axis=1)
    stored = values + (0 if bits == 32 else 2 ** (bits - 1))
    stored[:, :, :2] = [[[1, 200]]]
    same = {"samples": values.shape[2], "bits": bits, "channels": len(channels)}
    same.update({"data": len(channels), **more})
    header = channel_header(**same)
    kind = {8: "u1", 16: "<u2", 32: "<i4"}[bits]
    blocks = [header] * (same["data"] if same["data"] < 1024 else len(channels))
    if second is not None:
        blocks[1] = channel_header(**{**same, **second})
    path.write_bytes(b"".join(blocks) + stored.astype(kind).tobytes())


def write_dt1(path, kind="<i2", values=None, x=None, unit="m", dead=(), moved=(), **entries):
    values = counts() if values is None else values
    x = np.arange(len(values)) * SPACING_M if x is None else x
    lines = {
        "NUMBER OF TRACES": len(values),
        "NUMBER OF PTS/TRC": values.shape[1],
        "TIMEZERO AT POINT": "3.50",
        "TOTAL TIME WINDOW": f"{WINDOW_NS:.3f}",
        "POSITION UNITS": unit,
        "ANTENNA SEPARATION": "0.0500",
        **entries,
    }
    text = "1234\r\nData Collected with pE PRO\r\n2017-04-10\r\n"
    text += "".join(f"{key:19}= {value} \r\n" for key, value in lines.items())
    path.with_suffix(".HD").write_text(text, encoding="latin-1")
    with path.open("wb") as stream:
        for number, (trace, place) in enumerate(zip(values, x)):
            header = np.zeros(32, "<f4")
            header[:6] = number + 1, place, len(trace), 0.0, 0.0, np.dtype(kind).itemsize
            header[20] = number in moved  # item 21, adjustment of time zero
            header[21] = number in dead  # item 22 of the manual, the zero flag
            stream.write(header.tobytes() + trace.astype(kind).tobytes())


def write_rd3(path, values=None, **entries):
    bits = 16 if path.suffix.lower() == ".rd3" else 32
    values = counts(bits) if values is None else values
    lines = {
        "SAMPLES": values.shape[1],
        "FREQUENCY": values.shape[1] / WINDOW_NS * 1e3,
        "SIGNAL POSITION": -0.0456,
        "DISTANCE FLAG": 1,
        "TIME FLAG": 0,
        "DISTANCE INTERVAL": SPACING_M,
        "ANTENNAS": "1600 MHz",
        "ANTENNA SEPARATION": 0.06,
        "TIMEWINDOW": WINDOW_NS,
        "LAST TRACE": len(values),
        **entries,
    }
    text = "".join(f"{key}:{value}\r\n" for key, value in lines.items())
    path.with_suffix(".rad").write_text(text, encoding="latin-1")
    path.write_bytes(values.astype(f"<i{bits // 8}").tobytes())


def write_segy(path, code=5, order=">", values=None, text="C 1 OTHER PROGRAM", ebcdic=True, **more):
    """Write traces; `more` are fields of the headers of traces by place, such as b73."""
    values = counts(8) if values is None else values
    kind = order + {1: "f8", 2: "i4", 3: "i2", 5: "f4", 8: "i1"}[code]
    start = text.ljust(3200).encode("cp500" if ebcdic else "ascii")
    binary = bytearray(400)
    known = {3217: 200, 3221: values.shape[1], 3225: code, 3255: 1, 3501: 0, 3505: 0}
    for place, value in known.items():
        struct.pack_into(f"{order}H", binary, place - 3201, more.pop(f"b{place}", value))
    with path.open("wb") as stream:
        stream.write(start + bytes(binary))
        for number, trace in enumerate(values):
            header = bytearray(240)
            fields = {29: 1, 71: -1000, 73: 20 * number, 81: 20 * number, 115: len(trace), 117: 200}
            fields.update({int(key[1:]): value for key, value in more.items()})
            for place, value in fields.items():
                value = value[number] if isinstance(value, (list, np.ndarray)) else value
                long = place in (41, 73, 77, 81, 85, 181, 185)
                struct.pack_into(order + ("i" if long else "h"), header, place - 1, int(value))
            stream.write(header)
            if code == 1:
                pack_4byte_ibm(stream, trace.astype(np.float64), order)
            else:
                stream.write(trace.astype(kind).tobytes())


def write_touchstone(folder, names=None, form="RI", unit="MHz", hz=None):
    names = [f"X{20 * one}_Y0.s2p" for one in range(TRACES)] if names is None else names
    hz = np.linspace(1e9, 2e9, 11) if hz is None else hz
    folder.mkdir(exist_ok=True)
    scale = {"HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9}[unit.upper()]
    for number, name in enumerate(names):
        s21 = (number + 1) * 0.1 * np.exp(-2j * np.pi * hz * 1e-9)
        pair = {
            "RI": (s21.real, s21.imag),
            "MA": (np.abs(s21), np.degrees(np.angle(s21))),
            "DB": (20 * np.log10(np.abs(s21)), np.degrees(np.angle(s21))),
        }[form]
        columns = [hz / scale, *pair]
        if name.lower().endswith("2p"):
            columns = [hz / scale, *[np.zeros(len(hz))] * 2, *pair, *[np.zeros(len(hz))] * 4]
        lines = [" ".join(f"{one:.12g}" for one in row) for row in np.stack(columns, axis=1)]
        text = "\n".join(["! a VNA", f"# {unit} S {form} R 50", *lines, ""])
        (folder / name).write_text(text, encoding="ascii")


def write_merged(path, values=None, steps=(10, 0, 0), along="Ey", srcsteps=None):
    values = counts(8, samples=400) / 128.0 if values is None else values
    with h5py.File(path, "w") as file:
        file.attrs.update(gprMax="4", Iterations=values.shape[1], dt=20e-12, nsrc=1, nrx=1)
        if steps is not None:
            file.attrs.update(
                rxsteps=steps, srcsteps=srcsteps or steps, dx_dy_dz=(0.002, 0.002, 0.002)
            )
        receiver = file.create_group("rxs/rx1")
        for name in ("Ex", "Ey", "Ez"):
            receiver[name] = (1.0 if name == along else 0.01) * values.T


SPECTRA = {"source": RICKER[1], "band": Band(1e9, 2e9, 11)}
# Format, name, writer, options, and the files that can be damaged.
KINDS = {
    "dzt": ("l.dzt", write_dzt, {}, ("l.dzt",)),
    "dt1": ("l.dt1", write_dt1, {}, ("l.dt1", "l.HD")),
    "rd3": ("l.rd3", write_rd3, {}, ("l.rd3", "l.rad")),
    "segy": ("l.sgy", write_segy, {}, ("l.sgy",)),
    "touchstone": ("t", write_touchstone, {}, ("t/X0_Y0.s2p", "t/X40_Y0.s2p")),
    "gprmax": ("m.h5", write_merged, SPECTRA, ("m.h5",)),
}


def read(path, form, **options):
    return IMPORTS.find(form).read(path, ImportOptions(**options), no_progress)
