"""Damaged, foreign and older files: each error names the file, what is wrong, and what to do."""

import errno
import hashlib
import os
import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from semiwear.cli import main
from semiwear.errors import ResultFileError, SemiwearError
from semiwear.report import write_report
from semiwear.results import files, open_results, save
from semiwear.results.checkpoint import KeptStep, open_checkpoint, peek, remove_checkpoint
from tests.strategies.results import synthetic_tree

TREE = synthetic_tree(3, profiles=5, faces=4, mesh_positions=4)


def part(*groups):
    """A result of some of the groups: what damages one needs no others."""
    return xr.DataTree.from_dict(
        {"/": TREE.to_dataset(), **{f"/{group}": TREE[group].to_dataset() for group in groups}}
    )


ANEW = "compute it anew: semiwear run SCENE -o FILE"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "worn.nc"
    save(TREE, path)
    return path.read_bytes()


def _saved(path):
    other = path.with_name("other.nc")
    save(part("history"), other)
    return other.rename(path).read_bytes()


def cut(size):
    return lambda path, whole: path.write_bytes(whole[: int(size * len(whole)) if isinstance(size, float) else size])


def flipped(place):
    def damage(path, whole):
        content = bytearray(whole)
        content[int(place * len(whole))] ^= 4
        path.write_bytes(content)

    return damage


def sealed(change, group="history"):
    """A file with a good seal around what `change` makes of a result of one group."""

    def damage(path, whole):
        tree = part(group).copy(deep=True)
        changed = change(tree)
        (tree if changed is None else changed).to_netcdf(path, engine="netcdf4")
        seal(path)

    return damage


def seal(path):
    content = path.read_bytes()
    path.write_bytes(content + b"semiwear sha256:" + hashlib.sha256(content).digest())


def without(group, name):
    def change(tree):
        tree[group] = xr.DataTree(tree[group].to_dataset().drop_vars(name))

    return sealed(change, group)


def with_variable(path, change):
    group, name = path.split("/")

    def damage(tree):
        dataset = tree[group].to_dataset()
        tree[group] = xr.DataTree(dataset.assign({name: change(dataset[name])}))

    return sealed(damage, group)


def only(*groups):
    return sealed(lambda tree: part(*groups))


def version(text):
    def change(tree):
        tree.attrs["schema_version"] = text

    return sealed(change)


def other_netcdf(path, whole):
    xr.Dataset({"rain": ("time", np.zeros(3))}).to_netcdf(path)


def other_sealed_netcdf(path, whole):
    other_netcdf(path, whole)
    seal(path)


def appended_by_netcdf4(path, whole):
    path.write_bytes(whole)
    with netCDF4.Dataset(path, "a") as opened:
        opened.comment = "mine"


def with_nan(array):
    array = array.copy(deep=True)
    array.values[0] = np.nan
    return array


PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4
DAMAGES = {
    "empty": (cut(0), ["empty", ANEW]),
    "one byte": (cut(1), ["not a netCDF file, or damaged at its start", ANEW]),
    "seven bytes": (cut(7), ["damaged at its start", ANEW]),
    "the mark alone": (cut(8), ["damaged, cut off", ANEW]),
    "half": (cut(0.5), ["damaged, cut off", ANEW]),
    "a bit at the start": (flipped(0.0005), ["damaged, cut off", ANEW]),
    "zeros": (lambda path, whole: path.write_bytes(bytes(len(whole))), ["not a netCDF file"]),
    "a picture": (lambda path, whole: path.write_bytes(PNG), ["not a netCDF file", ANEW]),
    "a text": (lambda path, whole: path.write_text("meshes, depth\n1, 2\n"), ["not a netCDF file", ANEW]),
    "a scene": (lambda path, whole: path.write_text('title = "t"\n[wear]\n'), ["not a netCDF file", ANEW]),
    "a folder": (lambda path, whole: path.mkdir(), ["a folder; give the path of a result file in it"]),
    "a pipe": (lambda path, whole: os.mkfifo(path), ["not a plain file"]),
    "other netCDF": (other_netcdf, ["not of semiwear", "no schema_version", ANEW]),
    "sealed other netCDF": (other_sealed_netcdf, ["not of semiwear", "no schema_version", ANEW]),
    "a sealed text": (
        lambda path, whole: (path.write_bytes(b"\x89HDF\r\n\x1a\n and so on"), seal(path)),
        ["cannot be read as a netCDF file", ANEW],
    ),
    "older version": (version("0"), ["schema version 0 is older than this semiwear's 1", "compute it anew"]),
    "newer version": (version("12"), ["schema version 12 is newer", "open it with a newer semiwear"]),
    "strange version": (version("first"), ["'first' is not one of semiwear", ANEW]),
    "no groups": (only(), ["no group of a result", ANEW]),
    "other groups": (
        sealed(lambda tree: xr.DataTree.from_dict({"/": tree.to_dataset(), "/rain": xr.Dataset({"mm": 1.0})})),
        ["no group of a result", ANEW],
    ),
    "missing variable": (without("engagement", "load_share"), ["/engagement/load_share: missing", ANEW]),
    "missing meshes": (without("history", "meshes"), ["/history/meshes: missing", ANEW]),
    "missing coordinate": (without("flank", "face"), ["/flank/face: missing", ANEW]),
    "wrong dims": (
        with_variable("flank/wear_depth", lambda array: array.transpose()),
        ["/flank/wear_depth: dims", "expected ('wear_step', 'body', 'profile', 'face')", ANEW],
    ),
    "wrong units": (
        with_variable("flank/wear_depth", lambda array: array.assign_attrs(units="mm")),
        ["/flank/wear_depth: units 'mm', expected 'um'", ANEW],
    ),
    "no units": (
        with_variable("history/load_share_max", lambda array: array.drop_attrs()),
        ["/history/load_share_max: no units, expected '1'", ANEW],
    ),
    "not a number": (with_variable("history/load_share_max", with_nan), ["1 of 3 values are not finite", ANEW]),
    "text for numbers": (
        with_variable("history/load_share_max", lambda array: array.astype(str).assign_attrs(array.attrs)),
        ["/history/load_share_max: values of type", "must be real numbers", ANEW],
    ),
    "unknown flag": (with_variable("flank/zone", lambda array: array + 7), ["/flank/zone", ANEW]),
}


SLOWER = {"the mark alone", "a bit at the start"}  # each takes a process, like one that is cut off in the middle


@pytest.mark.parametrize("kind", [pytest.param(k, marks=pytest.mark.slow) if k in SLOWER else k for k in DAMAGES])
def test_the_error_says_what_is_wrong_and_what_to_do(tmp_path, whole, kind):
    path = tmp_path / "worn.nc"
    damage, words = DAMAGES[kind]
    damage(path, whole)
    with pytest.raises(ResultFileError) as caught:
        open_results(path)
    for word in [str(path), *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize("kind", ["a picture", "missing variable"])
def test_the_command_line_tells_the_error(tmp_path, whole, kind, capsys):
    path = tmp_path / "worn.nc"
    DAMAGES[kind][0](path, whole)
    assert main(["report", str(path)]) == 2
    told = capsys.readouterr()
    assert str(path) in told.err and "Traceback" not in told.err
    assert not path.with_suffix(".html").exists()


UNHARMED = {
    "without its seal": cut(-48),
    "with half a seal": cut(-1),
    "a bit in the seal": flipped(0.9999),
    "bytes behind": lambda path, whole: path.write_bytes(whole + b"\n"),
    "twice": lambda path, whole: path.write_bytes(whole + whole),
    "an attribute more": appended_by_netcdf4,
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", UNHARMED)
def test_what_others_add_is_no_damage(tmp_path, whole, kind, recwarn):
    path = tmp_path / "worn.nc"
    UNHARMED[kind](path, whole)
    found = open_results(path)
    assert not recwarn.list
    added = {"comment": "mine"} if kind == "an attribute more" else {}
    assert found.attrs == TREE.attrs | added
    for group in TREE.children:
        assert found[group].to_dataset().identical(TREE[group].to_dataset())


def test_data_that_others_change_are_named(tmp_path):
    path = tmp_path / "worn.nc"
    save(part("history"), path)
    with netCDF4.Dataset(path, "a") as opened:
        opened["history/load_share_max"][1] = 0.5
    with pytest.warns(UserWarning, match=r"worn\.nc: /history/load_share_max changed after semiwear saved them"):
        open_results(path)
    with netCDF4.Dataset(path, "a") as opened:
        opened.delncattr("check_sums")
    with pytest.warns(UserWarning, match="cannot be checked"):
        open_results(path)


@pytest.mark.parametrize("chunk", [1 << 20, 1000])
def test_what_was_saved_carries_its_seal_and_is_opened_without_a_process(tmp_path, whole, monkeypatch, chunk):
    monkeypatch.setattr(files, "_CHUNK", chunk)
    path = tmp_path / "worn.nc"
    save(part("history"), path)
    content = path.read_bytes()
    assert content[-48:] == b"semiwear sha256:" + hashlib.sha256(content[:-48]).digest()
    monkeypatch.setattr(files, "_probe", lambda source: pytest.fail("a sealed file was probed"))
    assert open_results(path).attrs == TREE.attrs
    for place in (0, len(content) // 2, len(content) - 49):
        changed = bytearray(content)
        changed[place] ^= 1
        path.write_bytes(b"\x89HDF\r\n\x1a\n" + changed[8:])
        assert files._sealed(path) == (place == 0)


def test_variables_that_are_gone_are_told_and_of_many_the_first_five(tmp_path):
    kept = "".join(f"/history/v{k} {k}\n" for k in range(7))
    for gone, others in ((5, ""), (6, " and others")):
        found = "".join(f"/history/v{k} {k}\n" for k in range(gone, 7))
        names = ", ".join(f"/history/v{k}" for k in range(5))
        with pytest.warns(UserWarning, match=f"worn.nc: {names}{others} changed after"):
            files._warn_of_changes(tmp_path / "worn.nc", kept, found)


def test_versions_are_compared_as_numbers(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "SCHEMA_VERSION", "10")
    for found, word in (("9", "older"), ("11", "newer")):
        with pytest.raises(ResultFileError, match=word):
            files._check_version(found, tmp_path / "worn.nc")
    files._check_version("10", tmp_path / "worn.nc")


def refuse(number):
    def fail(*_, **__):
        raise OSError(number, os.strerror(number))

    return fail


@pytest.mark.parametrize(
    ("number", "words"), [(errno.EACCES, "Permission denied"), (errno.EIO, "Input/output error")]
)
def test_a_file_that_may_not_be_read(tmp_path, whole, monkeypatch, number, words):
    path = tmp_path / "worn.nc"
    path.write_bytes(whole)
    monkeypatch.setattr(Path, "open", refuse(number))
    with pytest.raises(ResultFileError, match=rf"worn\.nc: cannot be read \({words}\); see that you may read it"):
        open_results(path)


def test_a_file_that_is_not_there_or_vanishes(tmp_path, whole, monkeypatch, capsys):
    path = tmp_path / "worn.nc"
    with pytest.raises(FileNotFoundError, match=r"no result file .*worn\.nc: give the path of a file that semiwear"):
        open_results(path)
    path.write_bytes(whole)
    check = files._sealed

    def and_gone(source):
        found = check(source)
        source.unlink()
        return found

    monkeypatch.setattr(files, "_sealed", and_gone)
    assert main(["report", str(path)]) == 2
    assert "no result file" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("groups", [("engagement", "mesh_cycle"), ("flank", "history")])
def test_a_result_of_part_of_the_groups_makes_a_report_or_says_why_not(tmp_path, whole, groups, capsys):
    path = tmp_path / "worn.nc"
    only(*groups)(path, whole)
    if main(["report", str(path)]) == 0:
        assert path.with_suffix(".html").read_text(encoding="utf-8").rstrip().endswith("</html>")
    else:
        told = capsys.readouterr().err
        assert "/" in told and "Traceback" not in told


def test_a_report_of_what_is_no_result(tmp_path):
    with pytest.raises(SemiwearError):
        write_report(xr.DataTree(), tmp_path / "worn.html")


# ---------------------------------------------------------------------- checkpoints

IDENTITY = {"scene": 'title = "t"', "semiwear": "1"}
REMEDY = "delete the folder, or run without --resume"


def run_json(change):
    def damage(path):
        file = path / "run.json"
        file.write_bytes(change(file.read_bytes()))

    return damage


def in_its_place(make):
    def damage(path):
        shutil.rmtree(path)
        make(path)

    return damage


def foreign(path):
    path.mkdir()
    (path / "thesis.tex").write_text("all of it", encoding="utf-8")


NOT_OURS = ["not a checkpoint of semiwear", "give a path where it may make a folder"]
BROKEN = {
    "run.json empty": (run_json(lambda whole: b""), ["does not say of which run it is", REMEDY]),
    "run.json cut": (run_json(lambda whole: whole[:-9]), ["does not say of which run it is", REMEDY]),
    "run.json of something else": (run_json(lambda whole: b"[1, 2]"), ["does not say of which run it is", REMEDY]),
    "a picture": (run_json(lambda whole: PNG), ["does not say of which run it is", REMEDY]),
    "another version": (
        run_json(lambda whole: whole.replace(b'"checkpoint": 2', b'"checkpoint": 1')),
        ["of another version of semiwear", REMEDY],
    ),
    "a result": (in_its_place(_saved), NOT_OURS),
    "a folder of something else": (in_its_place(foreign), NOT_OURS),
    "a pipe": (in_its_place(os.mkfifo), NOT_OURS),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_checkpoint_is_refused_and_left_alone(tmp_path, kind):
    path = tmp_path / "worn.nc.partial"
    with open_checkpoint(path, IDENTITY, resume=False) as kept:
        for k in range(3):
            kept.add(KeptStep(3, {}, {"wear": np.full(4, float(k))}))
    damage, words = BROKEN[kind]
    damage(path)
    before = {entry: entry.read_bytes() for entry in tmp_path.rglob("*") if entry.is_file()}
    with pytest.raises(ResultFileError) as caught:
        open_checkpoint(path, IDENTITY, resume=True)
    for word in [str(path), *words]:
        assert word in str(caught.value)
    assert peek(path) is None
    if words is NOT_OURS:
        with pytest.raises(ResultFileError):
            open_checkpoint(path, IDENTITY, resume=False)
        remove_checkpoint(path)
    assert {entry: entry.read_bytes() for entry in tmp_path.rglob("*") if entry.is_file()} == before


def test_only_what_is_its_own_is_removed(tmp_path):
    path = tmp_path / "worn.nc.partial"
    with open_checkpoint(path, IDENTITY, resume=False) as kept:
        kept.add(KeptStep(3, {}, {"wear": np.zeros(4)}))
    (path / "note.txt").write_text("mine", encoding="utf-8")
    remove_checkpoint(path)
    assert [entry.name for entry in path.iterdir()] == ["note.txt"]
    (path / "note.txt").unlink()
    open_checkpoint(path, IDENTITY, resume=True).close()
    remove_checkpoint(path)
    assert not path.exists()


def test_a_checkpoint_that_cannot_be_opened(tmp_path, monkeypatch):
    with pytest.raises(ResultFileError, match=r"the checkpoint cannot be opened .* give a place in a folder"):
        open_checkpoint(tmp_path / "nowhere" / "worn.nc.partial", IDENTITY, resume=False)
    path = tmp_path / "worn.nc.partial"
    monkeypatch.setattr(Path, "open", refuse(errno.EACCES))
    with pytest.raises(
        ResultFileError, match=r"cannot be opened \(Permission denied\); .* which you may read and write"
    ):
        open_checkpoint(path, IDENTITY, resume=True)
