"""Where the fields of MuJoCo's mjModel and mjData lie in memory.

The field order comes from ``mujoco.introspect``, the layout from ctypes, and the result is checked against the
addresses that the Python bindings report for a small model in which every field used is present.
"""

import ctypes
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

_SCALARS: dict[str, Any] = {
    "int": ctypes.c_int,
    "mjtSize": ctypes.c_int64,
    "size_t": ctypes.c_size_t,
    "uintptr_t": ctypes.c_size_t,
    "uint64_t": ctypes.c_uint64,
    "mjtNum": ctypes.c_double,
    "double": ctypes.c_double,
    "float": ctypes.c_float,
    "mjtByte": ctypes.c_ubyte,
    "mjtBool": ctypes.c_bool,
    "char": ctypes.c_char,
}


class Offsets(NamedTuple):
    """Byte offsets: pointers to arrays of mjtNum, but for ``time``, which is a number itself."""

    time: int
    qpos: int
    qvel: int
    qacc: int
    act: int
    act_dot: int
    ctrl: int
    userdata: int
    actuator_length: int
    actuator_velocity: int
    qfrc_passive: int
    xfrc_applied: int
    actuator_user: int


_OF_MODEL = ("actuator_user",)


class LayoutError(RuntimeError):
    """The installed MuJoCo lays its structs out otherwise than it says; nothing can be simulated safely."""


def _ctype(declared: Any, structs: Any, nodes: Any) -> Any:
    if isinstance(declared, nodes.PointerType):
        return ctypes.c_void_p
    if isinstance(declared, nodes.ArrayType):
        array = _ctype(declared.inner_type, structs, nodes)
        for extent in reversed(declared.extents):
            array = array * extent
        return array
    if isinstance(declared, nodes.AnonymousStructDecl):
        return _structure(declared, structs, nodes)
    if declared.name in _SCALARS:
        return _SCALARS[declared.name]
    if declared.name in structs:
        return _structure(structs[declared.name], structs, nodes)
    if declared.name.startswith("mjt"):  # the remaining ones are enums
        return ctypes.c_int
    raise LayoutError(f"mujoco {mujoco.__version__}: no size is known for the C type {declared.name}")


def _structure(declaration: Any, structs: Any, nodes: Any) -> Any:
    fields = [(field.name, _ctype(field.type, structs, nodes)) for field in declaration.fields]
    return type(getattr(declaration, "name", "anonymous"), (ctypes.Structure,), {"_fields_": fields})


_PROBE = """
<mujoco>
  <size nuserdata="5"/>
  <worldbody><body><joint name="a" type="slide"/><joint name="b" type="hinge"/><geom size="1"/></body></worldbody>
  <actuator><general joint="a" dyntype="user" actdim="3" user="1 2 3 4"/></actuator>
</mujoco>
"""


@cache
def offsets() -> Offsets:
    """The offsets for the installed MuJoCo, verified.

    Raises:
        LayoutError: if an address found through the offsets is not the one that the bindings report.
    """
    from mujoco.introspect import ast_nodes, structs

    data_type = _structure(structs.STRUCTS["mjData"], structs.STRUCTS, ast_nodes)
    model_type = _structure(structs.STRUCTS["mjModel"], structs.STRUCTS, ast_nodes)
    found = Offsets(*(getattr(model_type if f in _OF_MODEL else data_type, f).offset for f in Offsets._fields))
    model = mujoco.MjModel.from_xml_string(_PROBE)
    data = mujoco.MjData(model)
    data.time = 0.123456789
    seen = {"time": ctypes.c_double.from_address(data._address + found.time).value}
    expected = {"time": data.time}
    for name in Offsets._fields[1:]:
        owner = model if name in _OF_MODEL else data
        seen[name] = ctypes.c_void_p.from_address(owner._address + getattr(found, name)).value or 0
        array = getattr(owner, name)
        assert isinstance(array, np.ndarray)
        expected[name] = array.ctypes.data
    wrong = [name for name in seen if seen[name] != expected[name]]
    if wrong:
        raise LayoutError(f"mujoco {mujoco.__version__}: the fields {', '.join(wrong)} are not where they should be")
    return found
