"""No input runs code, opens other files, or fills the memory: hostile files before every input of the command line.

Each is refused by one message (exit 2) within a time that a waiting person bears; what a hostile file would do leaves
a mark, which is looked for; what it would draw in is a secret, which is looked for in everything that was said.
"""

import io
import json
import os
import pickle
import resource
import shutil
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from harness import Cli, Said, sealed_anew
from obspy.core.stream import _is_pickle
from scipy.io import savemat

from ehamj.plain.hdf5 import check_hdf5
from ehamj.plain.text import json_of, toml_of
from ehamj.plain.xml import check_xml, is_xml

SECRET = "the-secret-of-another-file"
RECORD = ("run", "recorded", "--no-replay", "--no-report", "--set", "compare=[]", "--set", "duration=0.05")
LONGEST = 10.0
"""Time of the processor within which any of these files must be refused [s]; the slowest takes a tenth of it."""
MOST = 2**29
"""Memory that a refusal may take beyond what was taken before [byte]."""


class Evil:
    """Whoever unpickles it writes a mark."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> tuple[Any, ...]:
        return os.system, (f"echo ran > '{self.mark}'",)


def pickled(protocol: int) -> Callable[[Path], bytes]:
    """A pickle that ObsPy's own detection takes for a stream."""
    return lambda folder: pickle.dumps(("obspy.core.stream", Evil(folder / "mark")), protocol)


def numpy_objects(folder: Path) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, np.array([Evil(folder / "mark")], object), allow_pickle=True)
    return buffer.getvalue()


def numpy_archive(folder: Path) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, z=np.array([Evil(folder / "mark")], object))
    return buffer.getvalue()


def matlab_objects(folder: Path) -> bytes:
    buffer = io.BytesIO()
    held = np.array([np.frombuffer(pickled(2)(folder), np.uint8), {"z": np.arange(20.0)}], object)
    savemat(buffer, {"z": held})
    return buffer.getvalue()


def yaml_tag(folder: Path) -> bytes:
    return f"!!python/object/apply:os.system ['echo ran > {folder / 'mark'}']\n".encode()


def outside_entity(folder: Path) -> bytes:
    return (
        f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY s SYSTEM "file://{folder / "secret"}">]>'
        '<FDSNStationXML xmlns="http://www.fdsn.org/xml/station/1" schemaVersion="1.1"><Source>&s;</Source>'
        "<Created>2026-01-01T00:00:00Z</Created></FDSNStationXML>"
    ).encode()


def laughs(folder: Path) -> bytes:
    lines = [f'<!ENTITY l{n} "{f"&l{n - 1};" * 10}">' for n in range(1, 12)]
    return f'<!DOCTYPE x [<!ENTITY l0 "lol">{"".join(lines)}]><FDSNStationXML>&l11;</FDSNStationXML>'.encode()


def laughs_in_utf16(folder: Path) -> bytes:
    return laughs(folder).decode().encode("utf-16")


def hdf5_file(folder: Path, fill: Callable[[h5py.File, Path], None]) -> bytes:
    path = folder / "made.h5"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time"], file["z"] = np.arange(20.0), np.arange(20.0)
        fill(file, folder)
    made = bytearray(path.read_bytes())
    path.unlink()
    made[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    return bytes(made)


def external_link(folder: Path) -> bytes:
    with h5py.File(folder / "other.h5", "w") as other:
        other["secret"] = np.arange(20.0)
    return hdf5_file(folder, lambda file, _: file.__setitem__("w", h5py.ExternalLink(folder / "other.h5", "secret")))


def external_storage(folder: Path) -> bytes:
    def fill(file: h5py.File, folder: Path) -> None:
        file.create_dataset("w", (20,), "u1", external=[(str(folder / "secret"), 0, 20)])

    return hdf5_file(folder, fill)


def virtual_array(folder: Path) -> bytes:
    def fill(file: h5py.File, folder: Path) -> None:
        layout = h5py.VirtualLayout((20,), "f8")
        layout[:] = h5py.VirtualSource(str(folder / "other.h5"), "secret", (20,))
        file.create_virtual_dataset("w", layout)

    return hdf5_file(folder, fill)


def unknown_filter(folder: Path) -> bytes:
    def fill(file: h5py.File, _: Path) -> None:
        del file["z"]  # the one that is picked
        created = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        created.set_chunk((20,))
        created.set_filter(32_999, h5py.h5z.FLAG_OPTIONAL, (1,))
        space = h5py.h5s.create_simple((20,))
        made = h5py.h5d.create(file.id, b"z", h5py.h5t.IEEE_F64LE, space, created)
        made.write_direct_chunk((0,), np.arange(20.0).tobytes())

    return hdf5_file(folder, fill)


def hdf5_bomb(folder: Path) -> bytes:
    def fill(file: h5py.File, _: Path) -> None:
        file.create_dataset("w", (2**36,), "f8", chunks=(2**16,), compression="gzip")

    return hdf5_file(folder, fill)


def packed(folder: Path) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("x.mseed", b"\0" * 2**24)
    return buffer.getvalue()


HOSTILE: dict[str, Callable[[Path], bytes]] = {
    **{f"pickle {protocol}": pickled(protocol) for protocol in (0, 2, 5)},
    **{
        made.__name__.replace("_", " "): made
        for made in (
            numpy_objects, numpy_archive, matlab_objects, yaml_tag, outside_entity, laughs, laughs_in_utf16,
            external_link, external_storage, virtual_array, unknown_filter, hdf5_bomb, packed,
        )
    },
    "deep": lambda folder: b"[" * 100_000,
    "dotted": lambda folder: b".".join([b"a"] * 100_000) + b" = 1",
    "constants": lambda folder: b'{"study": NaN, "settings": Infinity, "parts": [1e999]}',
    "nothing": lambda folder: b"",
}  # fmt: skip
"""Files by what they try."""

TEXTS = (
    "pickle 0",
    "pickle 5",
    "numpy objects",
    "yaml tag",
    "laughs",
    "external link",
    "deep",
    "dotted",
    "constants",
    "nothing",
)
"""Those that are put before readers of text."""

CODE = ("pickle 0", "pickle 2", "pickle 5", "numpy objects", "numpy archive", "yaml tag")
"""Those that would run code."""

ENDINGS = (
    "mseed", "sac", "gse", "csv", "txt", "dat", "asc", "uff", "unv", "mat", "wav", "npy", "npz", "pkl", "h5", "gz",
    "tdms", "ide", "at2", "",
)  # fmt: skip
"""Endings of records: those that have a reader, those that one would expect to have, and none."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "secret").write_text(SECRET)
    return tmp_path


@pytest.fixture(autouse=True)
def _bounded(tmp_path: Path) -> Iterator[None]:
    """Nothing ran, and neither time nor memory went without bounds."""
    before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    yield
    taken = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert not (tmp_path / "mark").exists(), "the file ran its code"
    assert time.process_time() - began < LONGEST * len(HOSTILE)
    assert taken * 1024 < MOST


def refused(said: Said) -> None:
    assert said.message
    assert SECRET not in said.err
    assert len(said.err) < 5000


def test_the_pickles_are_what_obspy_takes_for_a_stream(folder: Path) -> None:
    for protocol in (0, 2, 5):
        (folder / "x.mseed").write_bytes(pickled(protocol)(folder))
        assert _is_pickle(str(folder / "x.mseed"))
    pickle.loads(pickled(2)(folder))
    (folder / "mark").unlink()  # FileNotFoundError where the pickle did not run


@pytest.mark.parametrize("ending", ENDINGS)
def test_records(cli: Cli, folder: Path, ending: str) -> None:
    name = f"x.{ending}".strip(".")
    # Endings without a reader all lead to the same one: there what runs code is enough.
    (folder / name).write_bytes(b"")
    cli(*RECORD, "--set", f"ground={{kind='record', file='{name}', unit='m'}}")  # imports what is imported once
    for what in CODE if ending in ("sac", "gse", "npy", "npz", "pkl", "h5", "gz", "dat", "txt", "unv") else HOSTILE:
        (folder / name).write_bytes(HOSTILE[what](folder))
        began = time.process_time()
        scale = ", full_scale=1" if ending == "wav" else ""
        keys = f"kind='record', file='{name}', unit='m', axes={{z='z'}}, gaps='interpolate'{scale}"
        said = cli(*RECORD, "--set", f"ground={{{keys}}}")
        assert time.process_time() - began < LONGEST, what
        refused(said)


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("ground={{kind='record', file='example:BW.RJOB', inventory='{}'}}", "x.xml"),
        ("ground={{kind='record', file='example:BW.RJOB', inventory='{}'}}", "x.pz"),
        ("ground={{kind='broadband', target={{kind='file', file='{}'}}}}", "x.csv"),
        ("control={{kind='law', file='{}'}}", "x.json"),
        ("control={{kind='law', file='{}'}}", "x.mat"),
        ("criteria={{norms=['{}']}}", "x.csv"),
    ],
    ids=["inventory", "poles and zeros", "target", "law", "law of MATLAB", "limits"],
)
def test_files_that_a_scenario_names(cli: Cli, folder: Path, key: str, name: str) -> None:
    for what in HOSTILE if "inventory" in key else TEXTS:
        (folder / name).write_bytes(HOSTILE[what](folder))
        refused(cli(*RECORD, "--set", key.format(name)))


@pytest.mark.parametrize(
    "command",
    [
        ("run", "x.toml"), ("design", "x.toml"), ("modes", "x.toml"), ("transmissibility", "x.toml"),
        ("study", "gains", "x.toml"), ("study", "gains", "--settings", "x.toml"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_scenarios_and_settings(cli: Cli, folder: Path, command: tuple[str, ...]) -> None:
    for what in TEXTS:
        if what == "nothing" and "--settings" not in command:
            continue  # an empty scenario is all defaults
        made = HOSTILE[what]
        (folder / "x.toml").write_bytes(made(folder))
        refused(cli(*command))


@pytest.mark.parametrize(
    "key",
    [
        "ground={kind='record', file='x.wav', unit='m', full_scale=1}",
        *(f"ground={{kind='record', file='x.{end}', unit='m'}}" for end in (*ENDINGS, "a?c") if end != "wav"),
        "ground={kind='record', file='example:BW.RJOB', inventory='x.'}",
        "ground={kind='broadband', target={kind='file', file='x.csv'}}",
        "control={kind='law', file='x.json'}",
        "control={kind='law', file='x.mat'}",
        "criteria={norms=['x.csv']}",
    ],
)
def test_a_pipe_is_no_file(cli: Cli, folder: Path, key: str) -> None:
    """Nobody would ever write to it: whoever opens it waits."""
    for ending in {*ENDINGS, "abc", "json", "csv"}:
        os.mkfifo(folder / f"x.{ending}")
    waited, rescued = threading.Event(), threading.Event()

    def release() -> None:
        if not waited.wait(60.0):
            rescued.set()
            for path in folder.glob("x.*"):
                with suppress(OSError):  # nobody reads this one
                    os.close(os.open(path, os.O_WRONLY | os.O_NONBLOCK))

    rescue = threading.Thread(target=release)
    rescue.start()
    said = cli(*RECORD, "--set", key)
    waited.set()
    rescue.join()
    assert not rescued.is_set()
    refused(said)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result folder."""
    from ehamj.run.simulate import simulate
    from ehamj.scenario.load import load_scenario

    found = tmp_path_factory.mktemp("result") / "one"
    found.mkdir()
    simulate(load_scenario("benchmark", ["duration=0.01"])).write(found)
    return found


@pytest.mark.parametrize("name", ["result.nc", "summary.json", "scenario.toml", "model.xml", "controller.json"])
@pytest.mark.parametrize("command", ["report", "replay", "transmissibility"])
def test_results(cli: Cli, folder: Path, result: Path, command: str, name: str) -> None:
    every = HOSTILE if name == "result.nc" else TEXTS
    shutil.copytree(result, folder / "result")
    for what in every if command == "report" else ("pickle 2", "external link"):
        if what == "nothing" and name == "scenario.toml":
            continue
        (folder / "result" / name).write_bytes(HOSTILE[what](folder))
        refused(cli(command, "result"))


@pytest.mark.parametrize("text", ["<include file='secret'/>", "<asset><mesh file='secret'/></asset>"])
def test_a_stored_model_names_no_other_file(cli: Cli, folder: Path, result: Path, text: str) -> None:
    shutil.copytree(result, folder / "result")
    (folder / "result/model.xml").write_text(f"<mujoco>{text}</mujoco>")
    sealed_anew(folder / "result")  # as whoever means harm would
    said = cli("replay", "result")
    refused(said)
    assert "draws in another file" in said.message


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (external_link, "/w is a link into another file"),
        (external_storage, "/w keeps its values in another file"),
        (virtual_array, "/w keeps its values in another file"),
        (hdf5_bomb, "its arrays unfold to more than 4 GiB"),
    ],
)
def test_hdf5_stands_alone(folder: Path, made: Callable[[Path], bytes], message: str) -> None:
    (folder / "x.h5").write_bytes(made(folder))
    with pytest.raises(ValueError, match=message):
        check_hdf5(folder / "x.h5")


def test_hdf5_may_lead_around_in_itself(folder: Path) -> None:
    with h5py.File(folder / "x.h5", "w") as file:
        file["a/b"] = np.arange(3.0)
        file["a/up"] = file["/"]
        file["a/soft"] = h5py.SoftLink("/nowhere")
    check_hdf5(folder / "x.h5")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_a_document_type_is_found_in_every_encoding(encoding: str) -> None:
    text = '<?xml version="1.0"?>\n<!DOCTYPE a [<!ENTITY e "x">]><a>&e;</a>'.encode(encoding)
    assert is_xml(text)
    with pytest.raises(ValueError, match="document type"):
        check_xml(text)


def test_plain_xml_passes_and_broken_xml_does_not() -> None:
    check_xml(b"<a b='1'><c/></a>")
    with pytest.raises(ValueError, match="well-formed"):
        check_xml(b"<a>")
    assert not is_xml(b"0001")


def test_json_and_toml_have_bounds(folder: Path) -> None:
    for text, message in (("NaN", "no JSON"), ("[" * 10**5, "nested"), ("1" * 10**5, "digits"), ("{", "Expecting")):
        (folder / "x.json").write_text(text)
        with pytest.raises(ValueError, match=message):
            json_of(folder / "x.json")
    assert json.loads(json.dumps({"a": 1})) == {"a": 1}
    with pytest.raises(ValueError, match="nested"):
        toml_of("a = " + "[" * 10**5)
    with pytest.raises(ValueError, match=r"more than 50 dots \(at line 2\)"):
        toml_of("a = 1\n" + ".".join("b" * 100))
    assert toml_of(f"a = [{', '.join(['0.1'] * 200)}]\n b.c.d = 1.5")["b"] == {"c": {"d": 1.5}}
    with pytest.raises(OSError, match="no such file"):
        json_of(Path(os.devnull))  # a device is no file
