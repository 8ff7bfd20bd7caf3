"""MATLAB files of versions 5 to 7, read to the letter of MathWorks' "MAT-File Format", and no byte trusted.

SciPy's reader of these files is compiled and takes a file's own numbers for sizes and places in memory: damaged files
were seen to end the process. The layout: 128 bytes of header, then elements of a type, a number of bytes and as many
bytes. A matrix is an element of elements: flags, dimensions, name, and its contents; a compressed element holds one,
deflated.
"""

import struct
import zlib
from collections.abc import Iterator
from functools import partial
from math import prod
from typing import NamedTuple

import numpy as np

from ehamj.records.matlab_values import DEEPEST, MOST_PARTS, Numbers, Opaque, Value, dense

HEADER = 128
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
MATRIX, COMPRESSED = 14, 15
CELL, STRUCT, OBJECT, CHAR, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17
ARRAYS = range(6, 16)
COMPLEX, LOGICAL = 0x0800, 0x0200
LARGEST = 2**31
"""Bytes that compressed variables may become together."""


class Element(NamedTuple):
    """One element: its type, and its bytes."""

    kind: int
    data: memoryview

    def numbers(self, order: str) -> np.ndarray:
        if self.kind not in NUMBERS:
            raise ValueError(f"it is damaged: an element of type {self.kind} stands where numbers should")
        kind = np.dtype(order + NUMBERS[self.kind])
        return np.frombuffer(self.data[: len(self.data) // kind.itemsize * kind.itemsize], kind)

    def text(self, order: str) -> str:
        if self.kind not in TEXTS:
            raise ValueError(f"it is damaged: an element of type {self.kind} stands where text should")
        code = TEXTS[self.kind]
        ending = {"<": "-le", ">": "-be"}[order] if code in ("utf-16", "utf-32") else ""
        return bytes(self.data).decode(code + ending, "replace")


def variables(content: bytes, most: int = LARGEST) -> dict[str, Value]:
    """The variables of a file; raises ValueError where it is not laid out as it must be, or unfolds to ``most`` bytes
    or more."""
    return Level5("<" if content[126:128] == b"IM" else ">", most).variables(content)


class Level5:
    """Reads the elements of a file, which have one byte order."""

    def __init__(self, order: str, most: int) -> None:
        self.order = order
        self.most = most
        self.parts = 0
        self.inflated = 0

    def variables(self, content: bytes) -> dict[str, Value]:
        """The variables of a file, by name."""
        found = {}
        for element in self.elements(memoryview(content)[HEADER:]):
            for matrix in self.inflate(element.data) if element.kind == COMPRESSED else (element,):
                name, value = self.matrix(matrix, "", 0)
                if name:  # what has none is what objects keep for themselves
                    found[name] = value
        return found

    def elements(self, data: memoryview) -> Iterator[Element]:
        """The elements that follow each other."""
        at = 0
        while at + 8 <= len(data):
            kind, size = struct.unpack_from(f"{self.order}II", data, at)
            if kind >> 16:  # a small element: the bytes in the upper half, up to four data behind
                start, kind, size = at + 4, kind & 0xFFFF, min(kind >> 16, 4)
                at += 8
            else:
                start = at + 8
                at = start + size + (-size % 8 if kind != COMPRESSED else 0)
            if start + size > len(data):
                raise ValueError(f"it is truncated or damaged: {size} bytes are stated and {len(data) - start} follow")
            yield Element(kind, data[start : start + size])

    def inflate(self, data: memoryview) -> Iterator[Element]:
        """The matrix in a compressed element."""
        inflater = zlib.decompressobj()
        try:
            inner = inflater.decompress(data, self.most - self.inflated)
        except zlib.error as error:
            raise ValueError(f"it is damaged: {error}") from None
        self.inflated += len(inner)
        if inflater.unconsumed_tail or self.inflated >= self.most:
            raise ValueError(f"its variables unfold to more than {self.most / 2**30:.3g} GiB; cut it into parts")
        return self.elements(memoryview(inner))

    def matrix(self, element: Element, path: str, depth: int) -> tuple[str, Value]:
        """Name and value of a matrix."""
        self.parts += 1
        if element.kind != MATRIX:
            raise ValueError(f"it is damaged: an element of type {element.kind} stands where a variable should")
        if depth > DEEPEST or self.parts > MOST_PARTS:
            raise ValueError(f"{path} is more than {DEEPEST} structs deep, or has too many parts; save a plain struct")
        if not element.data:
            return "", []
        inner = self.elements(element.data)
        flags = int(self.next(inner, path).numbers(self.order)[:1].sum())
        kind = flags & 0xFF
        if kind == OPAQUE:
            names = [self.next(inner, path).text(self.order) for _ in range(3)]
            return names[0], Opaque(names[2])
        shape = tuple(int(n) for n in self.next(inner, path).numbers(self.order))
        own = self.next(inner, path).text(self.order).rstrip("\0")
        name = f"{path}.{own}" if path and own else path or own
        if len(shape) < 2 or min(shape) < 0 or (kind != SPARSE and prod(shape) > len(element.data)):
            raise ValueError(f"{name} states {' × '.join(map(str, shape))} parts in {len(element.data)} bytes")
        return own, self.contents(kind, flags, shape, inner, name, depth)

    def next(self, inner: Iterator[Element], path: str) -> Element:
        found = next(inner, None)
        if found is None:
            raise ValueError(f"it is damaged: {path or 'a variable'} breaks off")
        return found

    def contents(
        self, kind: int, flags: int, shape: tuple[int, ...], inner: Iterator[Element], name: str, depth: int
    ) -> Value:
        """What follows a matrix's name."""
        if kind == FUNCTION:
            return Opaque("function")
        if kind == OBJECT:
            return Opaque(self.next(inner, name).text(self.order))
        if kind == CELL:
            return [self.matrix(self.next(inner, name), name, depth + 1)[1] for _ in range(prod(shape))]
        if kind == STRUCT:
            return self.struct(prod(shape), inner, name, depth)
        if prod(shape) == 0:
            return "" if kind == CHAR else []
        if kind == CHAR:
            text = self.next(inner, name).text(self.order)
            rows = ["".join(text[row :: shape[0]]) for row in range(shape[0])]
            return rows[0] if len(rows) == 1 else list(rows)
        if kind == SPARSE:
            return self.sparse(shape, inner, name, bool(flags & COMPLEX))
        if kind not in ARRAYS:
            raise ValueError(f"it is damaged: {name} is of class {kind}")
        numbers = self.next(inner, name).numbers(self.order)
        if numbers.size != prod(shape):
            raise ValueError(f"{name} states {' × '.join(map(str, shape))} numbers and holds {numbers.size}")
        reshaped = partial(numbers.reshape, shape, order="F")
        return Numbers(shape, reshaped, bool(flags & COMPLEX), bool(flags & LOGICAL))

    def struct(self, count: int, inner: Iterator[Element], name: str, depth: int) -> Value:
        """A struct, or an array of them: names of a fixed length, then field by field, struct by struct."""
        width = int(self.next(inner, name).numbers(self.order)[:1].sum())
        text = self.next(inner, name).text(self.order)
        if not 0 < width <= 64:
            raise ValueError(f"it is damaged: {name} has fields of {width} letters")
        keys = [text[k : k + width].split("\0")[0] for k in range(0, len(text), width)]
        each = [
            {key: self.matrix(self.next(inner, name), f"{name}.{key}", depth + 1)[1] for key in keys}
            for _ in range(count if keys else 0)
        ]
        return each[0] if len(each) == 1 else list(each)

    def sparse(self, shape: tuple[int, ...], inner: Iterator[Element], name: str, is_complex: bool) -> Value:
        """A sparse matrix: rows, beginnings of columns, numbers."""
        from scipy.sparse import csc_matrix

        rows, begins, numbers = (self.next(inner, name).numbers(self.order) for _ in range(3))
        used = int(begins[-1]) if begins.size else 0
        if len(shape) != 2 or begins.size != shape[1] + 1 or not 0 <= used <= min(rows.size, numbers.size):
            raise ValueError(f"it is damaged: the sparse matrix {name} does not fit its dimensions")
        matrix = csc_matrix((numbers[:used].astype(float), rows[:used], begins), shape=shape)
        return Numbers(shape, lambda: dense(matrix, name), is_complex)
