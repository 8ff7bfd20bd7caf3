"""How Numba compiles a kernel: as a part of what calls it, and no further.

Left to itself it makes machine code of each function and a way for Python to call it, though a kernel is only ever
inlined into what calls it. Instructions are optimised as ever, kernel by kernel: loops that run over lanes are found in
small functions, not in large ones. So what runs is the same, compiled in half the time.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering


class _Part(JITCodeLibrary):
    """Instructions that are linked into what calls them; there is no machine code of them alone."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> Any:
        """Who sets the constants of machine code; see `set_env`."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """There is no machine code that would ask for it."""


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):
    """Numba's own, into a `_Part`."""

    _name = "kernel_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        return bool(super().run_pass(state))


class PartCompiler(CompilerBase):
    """Numba's own compiler but for the last step."""

    def define_pipelines(self) -> list[Any]:
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [(_Lowering, said) if one is NativeLowering else (one, said) for one, said in passes.passes]
        passes.finalize()
        return [passes]
