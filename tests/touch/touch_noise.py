"""What a broken or malicious display sends: noise, and orders that are none."""

import random
import re
from collections.abc import Iterator

ALPHABETS = (
    bytes(range(256)),
    b"#;0123456789,:. -",
    b"#;7 1,0:.",
    b"\xff\x00\x66\x24\x88#;21 ",
)
"""Bytes that noise is made of: any, and those that come far."""

SOUND = (
    "2 1", "2 0", "3 640.5", "4 35", "5 7.5", "6 0.02", "7 1,20,600:2,40,300:3,60,300:4,0,0:",
    "7 1,150,600,1:", "8 1", "9 0", "9 1", "10 2", "11 3", "12", "13 2", "14 fuse", "15 6", "16",
    "17", "18", "19 50", "20 900", "21 3", "22",
)  # fmt: skip

PIECES = (b"99999999999", b"-", b"..", b",,", b"::", b"e9", b" ", b"\xff\xff\xff")

_NUMBER = r"-?(?:\d+\.?\d*|\.\d+)"
_POINT = rf"\d+,{_NUMBER},{_NUMBER}(?:,\d+)?:"
_FORMS = re.compile(
    r"0*(?:(?:12|16|17|18|22) ?"
    rf"|(?:3|4|5|6|19|20) ?{_NUMBER}"
    r"|(?:2|8|9|10|11|13|15|21) ?\d+"
    r"|14 ?[ -~]{1,12}"
    rf"|7 ?(?:{_POINT})+)"
)
"""Generous: some of these are still refused, for what they say."""


def may_be_sound(text: str) -> bool:
    """True unless it is certain that an order is malformed."""
    return _FORMS.fullmatch(text) is not None


def orders_in(data: bytes) -> Iterator[str]:
    """What stands between `#` and `;`, in printable characters."""
    for found in re.finditer(rb"#([ -\"$-:<-~]*);", data):
        yield found[1].decode()


def noise(chance: random.Random, count: int) -> bytes:
    """Random bytes, from each of the alphabets in turn."""
    parts = []
    while count > 0:
        size = min(count, chance.randint(1, 500))
        parts.append(bytes(chance.choices(chance.choice(ALPHABETS), k=size)))
        count -= size
    return b"".join(parts)


def malformed(chance: random.Random) -> bytes:
    """Return an order that is none: a sound one with something wrong with it."""
    while True:
        data = _spoilt(chance, f"#{chance.choice(SOUND)};".encode())
        if not any(may_be_sound(text) for text in orders_in(data)):
            return data


def _spoilt(chance: random.Random, data: bytes) -> bytes:
    text = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        place = chance.randrange(len(text) + 1)
        match chance.randrange(5):
            case 0:
                text[place:place] = bytes([chance.randrange(256)])
            case 1:
                del text[place : place + 1]
            case 2:
                text[place:place] = chance.choice(
                    (b"99999999999", b"-", b"..", b",,", b"::", b"e9")
                )
            case 3:
                text[place:place] = bytes([chance.choice(b"0159,:. -")]) * chance.choice((40, 300))
            case _:
                text[place : place + 1] = bytes([chance.randrange(256)])
    return bytes(text)
