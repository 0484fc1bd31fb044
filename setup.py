"""Build the compiled kernel, which pyproject.toml cannot describe, and add the examples.

The kernel is compiled with the version that it goes by, if a C compiler is at hand.
"""

import re
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_py import build_py

KERNEL = Path("tendon_cli/kernel")
_CODE = (KERNEL / "__init__.py").read_text(encoding="utf-8")
VERSION = re.search(r"^VERSION = (\d+)$", _CODE, re.MULTILINE)[1]
# One wheel serves every Python from 3.11 on but the free-threaded ones, which need one each.
IS_LIMITED = not sysconfig.get_config_var("Py_GIL_DISABLED")
EXTENSION = Extension(
    "tendon_cli.kernel._native",
    sources=[str(KERNEL / f"{name}.c") for name in ("native", "plain", "avx2", "avx512")],
    depends=[str(path) for path in sorted(KERNEL.glob("*.h"))],
    define_macros=[("KERNEL_VERSION", VERSION)],
    extra_compile_args=[
        "-std=c11",
        "-O3",
        "-g0",
        "-ffp-contract=off",
        "-fno-math-errno",
        "-fno-trapping-math",
    ],
    py_limited_api=IS_LIMITED,
    optional=True,  # without a C compiler NumPy does it, to the same bits
)


class BuildWithExamples(build_py):
    """Copy the studies and readings of the documentation into the package, too.

    `tendon init --from` copies them from there.
    """

    def run(self):
        """Build as usual, then copy."""
        super().run()
        if self.editable_mode:
            return
        examples = Path(self.build_lib, "tendon_cli/examples")
        for source in sorted(Path("configs").rglob("*")):
            if source.suffix in (".toml", ".csv"):
                target = examples / source.relative_to("configs")
                self.mkpath(str(target.parent))
                self.copy_file(str(source), str(target))


setup(
    ext_modules=[EXTENSION],
    cmdclass={"build_py": BuildWithExamples},
    options={"bdist_wheel": {"py_limited_api": "cp311"}} if IS_LIMITED else {},
)
