"""A master for one co-simulation FMU of FMI 2.0, as far as a test needs one.

Called with the FMU, a directory for it, a start position, a period and a file of inputs, a line each. Prints the position, the current
and the reported position behind each of them."""

import ctypes
import os
import sys
import xml.etree.ElementTree
import zipfile

fmu, directory, start, period, inputs = sys.argv[1:]
with zipfile.ZipFile(fmu) as archive:
    assert archive.testzip() is None
    archive.extractall(directory)
root = xml.etree.ElementTree.parse(os.path.join(directory, "modelDescription.xml")).getroot()
assert root.tag == "fmiModelDescription" and root.get("fmiVersion") == "2.0"
simulation = root.find("CoSimulation")
variables = {it.get("name"): it for it in root.find("ModelVariables")}
reference = {name: int(it.get("valueReference")) for name, it in variables.items()}
outputs = [name for name, it in variables.items() if it.get("causality") == "output"]
order = list(variables)
assert [order[int(it.get("index")) - 1] for it in root.find("ModelStructure/Outputs")] == outputs
units = {it.get("name") for it in root.find("UnitDefinitions")}
assert all(it.find("Real").get("unit") in units | {None} for it in variables.values())
for source in simulation.find("SourceFiles"):
    assert os.path.isfile(os.path.join(directory, "sources", source.get("name")))

library = ctypes.CDLL(os.path.join(directory, "binaries", "linux64", simulation.get("modelIdentifier") + ".so"))
C = ctypes
libc = C.CDLL(None)
libc.calloc.restype = C.c_void_p
LOGGER = C.CFUNCTYPE(None, C.c_void_p, C.c_char_p, C.c_int, C.c_char_p, C.c_char_p)
ALLOCATE = C.CFUNCTYPE(C.c_void_p, C.c_size_t, C.c_size_t)
FREE = C.CFUNCTYPE(None, C.c_void_p)
FINISHED = C.CFUNCTYPE(None, C.c_void_p, C.c_int)


class Callbacks(C.Structure):
    _fields_ = [("logger", LOGGER), ("allocate", ALLOCATE), ("free", FREE), ("finished", FINISHED), ("environment", C.c_void_p)]


said = []
living = set()


def allocate(count, size):
    place = libc.calloc(C.c_size_t(count), C.c_size_t(size))
    living.add(place)
    return place


def free(place):
    living.remove(place)
    libc.free(C.c_void_p(place))


callbacks = Callbacks(LOGGER(lambda *message: said.append(message)), ALLOCATE(allocate), FREE(free), FINISHED(), None)
library.fmi2GetVersion.restype = C.c_char_p
library.fmi2GetTypesPlatform.restype = C.c_char_p
assert library.fmi2GetVersion() == b"2.0" and library.fmi2GetTypesPlatform() == b"default"
library.fmi2Instantiate.restype = C.c_void_p
library.fmi2Instantiate.argtypes = [C.c_char_p, C.c_int, C.c_char_p, C.c_char_p, C.POINTER(Callbacks), C.c_int, C.c_int]
library.fmi2DoStep.argtypes = [C.c_void_p, C.c_double, C.c_double, C.c_int]
library.fmi2FreeInstance.argtypes = [C.c_void_p]
library.fmi2FreeInstance.restype = None


def instantiate(kind, guid):
    return library.fmi2Instantiate(b"one", kind, guid, b"", C.byref(callbacks), 0, 0)


guid = root.get("guid").encode()
# Another model's GUID and model exchange are refused, and said to be.
assert instantiate(1, b"{other}") is None and instantiate(0, guid) is None and len(said) == 2
own = instantiate(1, guid)
assert own is not None


def call(name, *arguments):
    status = getattr(library, name)(C.c_void_p(own), *arguments)
    assert status == 0, (name, status)


def set_real(name, value):
    call("fmi2SetReal", C.byref(C.c_uint(reference[name])), C.c_size_t(1), C.byref(C.c_double(value)))


def get_real(name):
    value = C.c_double()
    call("fmi2GetReal", C.byref(C.c_uint(reference[name])), C.c_size_t(1), C.byref(value))
    return value.value


def run(rows, first):
    found = []
    for row, value in enumerate(rows, first):
        set_real("input", value)
        call("fmi2DoStep", C.c_double(row * period), C.c_double(period), C.c_int(1))
        found.append([get_real(name) for name in ("position", "current", "reported")])
    return found


start, period = float(start), float(period)
rows = [float(line) for line in open(inputs)]
call("fmi2SetupExperiment", C.c_int(0), C.c_double(0.0), C.c_double(0.0), C.c_int(0), C.c_double(0.0))
set_real("start_position", start)
call("fmi2EnterInitializationMode")
call("fmi2ExitInitializationMode")
# No time, and none that runs backwards, is passed.
for step in (float("nan"), float("inf"), -period):
    assert library.fmi2DoStep(C.c_void_p(own), 0.0, step, 1) == 3
half = len(rows) // 2
found = run(rows[:half], 0)
kept = C.c_void_p()
call("fmi2GetFMUstate", C.byref(kept))
first = run(rows[half:], half)
call("fmi2SetFMUstate", kept)
again = run(rows[half:], half)
assert first == again
call("fmi2FreeFMUstate", C.byref(kept))
call("fmi2Terminate")
library.fmi2FreeInstance(own)
assert not living
for row in found + first:
    print(*(repr(value) for value in row))
