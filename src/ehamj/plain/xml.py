"""XML without a document type: no entities, so that nothing is drawn in from elsewhere and nothing multiplies."""

from collections.abc import Callable
from xml.parsers import expat


def is_xml(data: bytes) -> bool:
    """Whether the first character is that of XML, in any encoding that XML may have."""
    return data[:64].replace(b"\0", b"").lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n").startswith(b"<")


def check_xml(data: bytes, element: Callable[[str, dict[str, str]], None] = lambda name, attributes: None) -> None:
    """Raise ValueError unless ``data`` is well-formed XML without a document type.

    Expat stops at the declaration, before any entity in it is read. ``element`` sees each element's name and attributes
    and may refuse it.
    """
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refused
    parser.EntityDeclHandler = _refused
    parser.StartElementHandler = element
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise ValueError(f"it is no well-formed XML: {error}") from None


def _refused(*declared: object) -> None:
    raise ValueError("it declares a document type, by which XML draws in other files; delete the DOCTYPE")
