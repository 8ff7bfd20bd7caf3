"""What a unit's script needs of ehamj: variables as PythonFMU has them, and the description with units."""

import sys
from collections.abc import Callable
from functools import partial
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from ehamj.errors import InputError, SimulationFailed
from ehamj.export.fmu.interface import Variable
from ehamj.export.fmu.unit import Unit
from ehamj.export.fmu.units import unit


def told(do: Callable[..., None], *given: Any) -> None:
    """Do something; what is wrong with it is said on stderr too, since masters log only where they are asked to."""
    try:
        do(*given)
    except (InputError, SimulationFailed) as error:
        print(f"ehamj: {error}", file=sys.stderr, flush=True)
        raise


def stepped(slave: Any, own: Unit, pythonfmu: Any, time: float, seconds: float) -> bool:
    """Step; False where that cannot be, which PythonFMU makes ``fmi2Discard``: the unit stays as it is, and usable.

    An exception would be ``fmi2Fatal`` to it, after which a host that goes on crashes.
    """
    try:
        told(own.step, time, seconds)
    except (InputError, SimulationFailed) as error:
        slave.log(f"ehamj: {error}", pythonfmu.enums.Fmi2Status.discard)
        return False
    return True


def register(slave: Any, own: Unit, pythonfmu: Any) -> None:
    """Register a unit's variables with a slave of PythonFMU's, the module that is in the unit."""
    causality, variability, initial = pythonfmu.Fmi2Causality, pythonfmu.Fmi2Variability, pythonfmu.Fmi2Initial
    fixed = {"causality": causality.parameter, "variability": variability.fixed, "initial": initial.exact}
    moving = {"variability": variability.continuous}

    def add(one: Variable, get: Any, put: Any, **kind: Any) -> None:
        unsaid = one.unit != "-" and unit(one.unit).name == "1"
        text = f"{one.text} [{one.unit}]" if unsaid else one.text
        made = getattr(pythonfmu, one.type)(one.name, description=text, getter=get, setter=put, **kind)
        slave.register_variable(made, nested=False)

    for one in own.parameters:
        add(one, partial(own.value, one.name), partial(own.set_value, one.name), **fixed)
    for number, one in enumerate(own.inputs):
        add(one, partial(own.held, number), partial(own.hold, number), causality=causality.input, **moving)
    for number, one in enumerate(own.outputs):
        add(one, partial(own.output, number), None, causality=causality.output, **moving)


def describe(root: Element, own: Unit) -> Element:
    """A description as PythonFMU writes it, with units and the unknowns of the initialisation."""
    definitions, known = Element("UnitDefinitions"), set[str]()
    places = {variable.get("name"): variable for variable in root.iter("ScalarVariable")}
    for one in own.variables:
        found = unit(one.unit)
        if one.type != "Real" or found.name == "1":
            continue
        places[one.name][0].set("unit", found.name)
        if found.name in known:
            continue
        known.add(found.name)
        definition = SubElement(definitions, "Unit", name=found.name)
        if found.exponents is not None:
            factor = {} if found.factor == 1.0 else {"factor": repr(found.factor)}
            SubElement(definition, "BaseUnit", {**{base: str(n) for base, n in found.exponents.items()}, **factor})
    at = list(root).index(root.find("CoSimulation"))  # type: ignore[arg-type]
    root.insert(at + 1, definitions)
    structure = root.find("ModelStructure")
    assert structure is not None
    unknowns = SubElement(structure, "InitialUnknowns")
    for output in structure.findall("Outputs/Unknown"):
        SubElement(unknowns, "Unknown", index=output.get("index", ""))
    return root
