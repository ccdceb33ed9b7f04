"""Results that strangers send: what `save` does not write is refused before it is decoded."""

import base64
import hashlib
import json
import os
import pickle
import subprocess
import sys
import time
import zlib

import netCDF4
import numpy as np
import pytest

import poinsot as pt

BODY = pt.Body((1.25, 1.0, 0.75))
MOTION = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.2, 0.3)), np.linspace(0, 1, 5))

NOT_SAVED = r"must be a whole result as save writes it, got another"


@pytest.fixture
def store(tmp_path):
    return pt.save(MOTION, tmp_path / "it.zarr")


class Touch:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return os.mknod, (self.path,)


# ------------------------------------------------------------------ Zarr


MEMBERS = pt.free_motion(BODY, BODY.state((1, 0, 0, 0), omega_body=np.eye(3)), np.linspace(0, 1, 5))


@pytest.fixture
def many(tmp_path):
    return pt.save(MEMBERS, tmp_path / "many.zarr")


def edit_array(store, name, **change):
    """Change what a store says of an array, and its digest so that it is right."""
    edit(store, lambda arrays, _: arrays[name].update(change))


def edit(store, change):
    """Change what a store says of its arrays and itself, and its digest so that it is right."""
    path = store / "zarr.json"
    record = json.loads(path.read_text())
    arrays = record["consolidated_metadata"]["metadata"]
    attributes = {key: value for key, value in record["attributes"].items() if key != "digest"}
    change(arrays, attributes)
    digest = hashlib.sha256(json.dumps([arrays, attributes], sort_keys=True).encode()).hexdigest()
    record["attributes"] = {**attributes, "digest": digest}
    path.write_text(json.dumps(record))


def grid(*shape):
    return {"name": "regular", "configuration": {"chunk_shape": list(shape)}}


BYTES = {"name": "bytes", "configuration": {"endian": "little"}}
PICKLE = {"name": "numcodecs.pickle"}
OTHER = {
    "pickle": {"codecs": [PICKLE]},
    "pickled text": {"codecs": [{"name": "vlen-utf8"}, PICKLE], "data_type": "string"},
    "records": {"data_type": {"name": "structured", "configuration": {"fields": [["a", "float64"]]}}},
    "raw bytes": {"data_type": "r64"},
    "dates": {"data_type": {"name": "numpy.datetime64", "configuration": {"unit": "s", "scale_factor": 1}}},
    "truth": {"data_type": "bool"},
    "blosc": {"codecs": [BYTES, {"name": "blosc", "configuration": {"cname": "lz4"}}]},
    "gzip": {"codecs": [BYTES, {"name": "gzip", "configuration": {"level": 9}}]},
    "no checksum": {"codecs": [BYTES]},
    "no codecs": {"codecs": []},
    "big endian": {"codecs": [{"name": "bytes", "configuration": {"endian": "big"}}, {"name": "crc32c"}]},
    "single": {"data_type": "float32"},
    "a huge chunk": {"chunk_grid": grid(400_000_000)},
    "small chunks": {"chunk_grid": grid(1)},
    "a huge shape": {"shape": [400_000_000], "chunk_grid": grid(400_000_000)},
    "beyond all numbers": {"shape": [10**30], "chunk_grid": grid(10**30)},
    "less than nothing": {"shape": [-5], "chunk_grid": grid(-5)},
    "truth as a length": {"shape": [True], "chunk_grid": grid(True)},
    "a broken length": {"shape": [5.0], "chunk_grid": grid(5.0)},
    "no shape": {"shape": None},
    "two dimensions of huge": {"shape": [2**40, 2**40], "chunk_grid": grid(2**40, 2**40)},
    "a fill value": {"fill_value": 1.0},
    "folders": {"chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}}},
    "another format": {"zarr_format": 2},
    "a transformer": {"storage_transformers": [{"name": "any"}]},
    "more": {"more": 1},
}


@pytest.mark.parametrize("name", OTHER)
def test_no_store_names_what_decodes_it(store, tmp_path, name):
    (store / "time" / "c.0").write_bytes(pickle.dumps(Touch(tmp_path / "ran")))
    edit_array(store, "time", **OTHER[name])
    with pytest.raises(ValueError, match=NOT_SAVED):
        pt.load(store)
    assert not (tmp_path / "ran").exists()


def test_edits_of_arrays_are_complete(store):
    """So that the tests above and below refuse what they change, and not the digest."""
    edit_array(store, "time")
    assert np.array_equal(pt.load(store).quaternion, MOTION.quaternion)


SHARDING = {"codecs": [BYTES, {"name": "crc32c"}], "index_codecs": [BYTES, {"name": "crc32c"}]}
OTHER_SHARDS = {
    "codecs inside": {**SHARDING, "chunk_shape": [3, 5, 4], "codecs": [PICKLE], "index_location": "end"},
    "codecs of the index": {**SHARDING, "chunk_shape": [3, 5, 4], "index_codecs": [PICKLE], "index_location": "end"},
    "the index at the start": {**SHARDING, "chunk_shape": [3, 5, 4], "index_location": "start"},
    "blocks of two": {**SHARDING, "chunk_shape": [2, 5, 4], "index_location": "end"},
    "blocks of none": {**SHARDING, "chunk_shape": [0, 5, 4], "index_location": "end"},
    "cut times": {**SHARDING, "chunk_shape": [3, 1, 4], "index_location": "end"},
}


@pytest.mark.parametrize("name", OTHER_SHARDS)
def test_shards_are_as_they_are_written(many, name):
    edit_array(many, "quaternion", codecs=[{"name": "sharding_indexed", "configuration": OTHER_SHARDS[name]}])
    with pytest.raises(ValueError, match=NOT_SAVED):
        pt.load(many)


@pytest.mark.parametrize("shape", [[3 * 10**9, 5, 4], [3, 5 * 10**9, 4], [4, 5, 4], [2, 5, 4]])
def test_announced_sizes_are_those_of_the_files(many, shape):
    """Nothing is allocated for them."""
    sharding = {**SHARDING, "chunk_shape": [3, *shape[1:]], "index_location": "end"}
    codecs = [{"name": "sharding_indexed", "configuration": sharding}]
    edit_array(many, "quaternion", shape=shape, chunk_grid=grid(3, *shape[1:]), codecs=codecs)
    with pytest.raises(ValueError, match=f"{NOT_SAVED}|must have numbers of shape"):
        pt.load(many)


@pytest.mark.parametrize("place", [0, 100, -30, -1])
def test_bits_that_change_are_found(many, place):
    path = many / "quaternion" / "c.0.0.0"
    content = bytearray(path.read_bytes())
    content[place] ^= 1
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"(checksum|index) differs"):
        np.asarray(pt.load(many).quaternion)


def test_no_decoder_is_imported(store):
    """The law: stores are read by this package alone, so that no codec is reached, whatever a store says."""
    code = (
        "import sys, poinsot as pt; pt.load(sys.argv[1]); "
        "sys.exit(bool({'zarr', 'numcodecs', 'pickle5'} & set(sys.modules)))"
    )
    subprocess.run([sys.executable, "-c", code, store], check=True)


def test_other_metadata_of_a_store_is_not_read(store):
    """Those of format 2 and of single arrays, which say something else, and groups below."""
    (store / ".zmetadata").write_text(json.dumps({"metadata": {"time/.zarray": {"compressor": {"id": "pickle"}}}}))
    (store / "time" / "zarr.json").write_text(json.dumps({"zarr_format": 3, "codecs": [PICKLE]}))
    (store / "group").mkdir()
    (store / "group" / "zarr.json").write_text("{}")
    assert np.array_equal(pt.load(store).quaternion, MOTION.quaternion)


@pytest.mark.parametrize("name", ["zarr.json", "time/c.0", "time"])
def test_links_lead_nowhere(store, tmp_path, name):
    (store / name).rename(tmp_path / "elsewhere")
    (store / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match=f"{NOT_SAVED}: .*(is a link|symbolic links)"):
        pt.load(store)


@pytest.mark.parametrize("name", ["quaternion/c.0.0.0", "chunks/000000", "chunks/000000/zarr.json"])
def test_links_of_shards_lead_nowhere(many, tmp_path, name):
    (many / name).rename(tmp_path / "elsewhere")
    (many / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ValueError, match=f"{NOT_SAVED}: .*(is a link|symbolic links)"):
        pt.load(many)


@pytest.mark.parametrize("name", ["zarr.json", "time/c.0"])
def test_what_is_no_file_is_not_waited_for(store, name):
    (store / name).unlink()
    os.mkfifo(store / name)
    with pytest.raises(ValueError, match=f"{NOT_SAVED}|must be a Zarr store"):
        pt.load(store)


TEXTS = {
    "nested": "[" * 100_000,
    "nested tables": '{"a":' * 100_000,
    "long": '{"a": "' + "x" * 10_000_000 + '"}',
    "list": "[]",
    "number": "1",
    "empty": "",
    "bytes": "\ud800",
    "digits": '{"attributes": [' + "9" * 5000 + "]}",
}


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("name", ["zarr.json", "chunks/000000/zarr.json"])
def test_other_texts(many, name, text):
    (many / name).write_bytes(TEXTS[text].encode(errors="surrogatepass"))
    with pytest.raises(ValueError, match=NOT_SAVED):
        pt.load(many)


ATTRIBUTES = {
    "no failures": ("chunks/000000", {"failures": None}),
    "other failures": ("chunks/000000", {"failures": {"x": "y"}}),
    "no run": ("chunks/000000", {"run": {}}),
    "another run": ("chunks/000000", {"run": [1]}),
    "other events": (".", {"events": 5}),
    "events without names": (".", {"events": [{}]}),
    "no store": (".", {"store": None}),
    "members that are none": (".", {"store": {"format": 1, "members": -3, "chunk": 3}}),
    "other members": (".", {"store": {"format": 1, "members": 4, "chunk": 3}}),
    "another format": (".", {"store": {"format": 2, "members": 3, "chunk": 3}}),
    "another method": (".", {"method": "guess"}),
    "other steps": (".", {"steps": "many"}),
}


@pytest.mark.parametrize("name", ATTRIBUTES)
def test_other_attributes(many, name):
    place, change = ATTRIBUTES[name]
    edit(many / place, lambda _, attributes: attributes.update(change))
    with pytest.raises(ValueError):
        np.asarray(pt.load(many).quaternion)


def test_changed_attributes_are_found(store):
    text = (store / "zarr.json").read_text()
    (store / "zarr.json").write_text(text.replace("closed form", "Taylor", 1))
    with pytest.raises(ValueError, match="the digest differs"):
        pt.load(store)


# ------------------------------------------------------------------ NetCDF


HDF = {
    "a group that is in itself": (
        "c-rgqaB<`1lHy|G;9!7(|4?AY2;mz*#WxGTv-"
        "9_G31VWXU=l)B2m@S93_vYxJPbgJF?}=4JP!t{fki^=Oo(v;FUSc@xv4NWh_N!TFff5wc9c3nlxOt=0JTIm8~"
    ),
    "a link to itself": ("c-rgqaB<`1lHy|G;9!7(|4^_Q$~S=0?de(?{vIwtObiuFLdXhXfQyNNk%55?Xc8j_BV#cmgFb@~166_8xz0oYO1L0W"),
    "a link to another file": (
        "c-rgqaB<`1lHy|G;9!7(|4^_Q$~S=0?de(?{vIwtObiuFLdXhXfQyNNk%56thJk^R!+||FKQ}e6q?n(9AuTg4pFtnWXJD{kARF9mT|N~6iU}yJ"
    ),
    "numbers in another file": (
        "c-"
        "rgqaB<`1lHy|G;9!7(|1iJ^;Tu53r!JcL+TX(^h>4+sNeD$D6mT&y0JX3I<ro>*bMtdk^Gb?0!%THzpaLlA6nPAG0wV(>qX+{76C"
        ")!dGgJ;vi!d+>D%dkXJmkP&!p&gvA1KKRbR9Dny9Q7v1IUGp4Ev!T<Uq4U0!niLeZtHL^Bqi-p@m^kfO^9NEgr6p0U)*lR7?O$-"
        ")BTso0gfD&j9u{syYC7VmOx"
    ),
}
"""Files of h5py, compressed; what they lead to is `fifo`, which never answers who opens it."""


@pytest.mark.parametrize("name", HDF)
def test_pointers_of_a_file_are_followed_in_another_process(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo")
    (tmp_path / "it.nc").write_bytes(zlib.decompress(base64.b85decode(HDF[name])))
    began = time.process_time()
    with pytest.raises(ValueError, match=NOT_SAVED):
        pt.load("it.nc")
    assert time.process_time() - began < 1


def copied(path, change):
    """A result whose variable `time` is made by `change`, given the file."""
    good = pt.save(MOTION, path.with_name("good.nc"))
    with netCDF4.Dataset(good) as source, netCDF4.Dataset(path, "w") as target:
        target.setncatts(source.__dict__)
        for name, dimension in source.dimensions.items():
            target.createDimension(name, None if name == "time" else len(dimension))
        for name, variable in source.variables.items():
            if name != "time" and variable.dtype != str and "time" not in variable.dimensions:
                target.createVariable(name, variable.dtype, variable.dimensions)[...] = variable[...]
        change(target)


NETCDF = {
    "one huge chunk": lambda file: file.createVariable("time", "f8", ("time",), zlib=True, chunksizes=(20_000_000,)),
    "chunks": lambda file: file.createVariable("time", "f8", ("time",)),
    "text": lambda file: file.createVariable("time", str, ("axis",)),
    "letters": lambda file: file.createVariable("time", "S1", ("axis",)),
    "records": lambda file: file.createVariable(
        "time", file.createCompoundType(np.dtype([("a", "f8")]), "pair"), ("axis",)
    ),
    "a list in each place": lambda file: file.createVariable("time", file.createVLType("f8", "list"), ("axis",)),
    "names of numbers": lambda file: file.createEnumType("i1", "names", {"a": 1}),
    "groups": lambda file: file.createGroup("a/b/c"),
    "an array as an attribute": lambda file: file.setncattr("title", np.arange(3.0)),
    "texts as an attribute": lambda file: file.setncattr_string("title", ["a", "b"]),
    "more than it has": lambda file: file.createVariable("time", "f8", (file.createDimension("n", 10**9),)),
}


@pytest.mark.parametrize("name", NETCDF)
def test_no_file_has_what_decodes_to_more(tmp_path, name):
    copied(tmp_path / "it.nc", NETCDF[name])
    with pytest.raises(ValueError, match=NOT_SAVED):
        pt.load(tmp_path / "it.nc")


def test_a_text_that_is_there_many_times_takes_no_memory(tmp_path):
    """An attribute of 3000 references to one megabyte."""
    path, size = pt.save(MOTION, tmp_path / "it.nc"), 1_000_000
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr_string("large", "x" * size)
        file.setncattr_string("bomb", ["abcdefg"] * 3000)
    content = bytearray(path.read_bytes())
    large = content.find(size.to_bytes(4, "little"))
    first = next(
        i for i in range(len(content)) if all(content[i + 16 * k : i + 16 * k + 4] == b"\7\0\0\0" for k in range(9))
    )
    content[first : first + 16 * 3000] = content[large : large + 16] * 3000
    path.write_bytes(content)
    with pytest.raises(ValueError, match=f"{NOT_SAVED}: .*(gives up|memory)"):
        pt.load(path)


def test_a_file_that_is_open_elsewhere_is_read(tmp_path):
    """It ended the interpreter: the library was asked for the same file twice."""
    path = pt.save(MOTION, tmp_path / "it.nc")
    with netCDF4.Dataset(path):
        for _ in range(3):
            assert np.array_equal(pt.load(path).quaternion, MOTION.quaternion)


def test_relative_paths_are_those_of_this_process(tmp_path, monkeypatch):
    pt.save(MOTION, tmp_path / "it.nc")
    monkeypatch.chdir(tmp_path)
    assert np.array_equal(pt.load("it.nc").quaternion, MOTION.quaternion)
