"""Names that a spec may use: they become C identifiers and file names."""

import re

from heatwright.spec.problems import refuse

LONGEST_NAME = 24
"""Maximum length: C11 distinguishes 63 characters, the longest prefix and suffix included."""

NAME = r"^[a-z][a-z0-9]*(_[a-z0-9]+)*$"
_NAME = re.compile(NAME)

# C11's lower-case keywords, main, names of stdbool.h and avr-gcc, predefined macros of gcc's gnu
# dialects; then the names of devices that Windows reserves, because a folder and a file have the
# controller's name.
_RESERVED = """
    auto break case char const continue default do double else enum extern float for goto if
    inline int long register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while asm typeof linux unix bool true false main
    aux con nul prn com1 com2 com3 com4 com5 com6 com7 com8 com9
    lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 lpt9
"""
RESERVED = frozenset(_RESERVED.split())


def check_name(name: str) -> None:
    """Raise a PydanticCustomError unless `name` can be used as it is in C and as a file name."""
    if len(name) > LONGEST_NAME:
        raise refuse(
            f"the name has {len(name)} characters", f"Use at most {LONGEST_NAME} characters"
        )
    if not _NAME.fullmatch(name):
        raise refuse(
            f"{name!r} cannot be a name in the generated C",
            "Use lower-case letters, digits and single _, with a letter first",
        )
    if name in RESERVED:
        by = "C or an operating system"
        raise refuse(f"{name!r} is reserved by {by}", f"Use another, such as {name}_1")
