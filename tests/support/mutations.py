"""Damages files; the same seed gives the same damage."""

import random
import re

# Values for counts and offsets of a damaged file.
NUMBERS = [b"0", b"-1", b"1", b"3", b"255", b"65536", b"2147483647", b"-2147483648", b"4294967296", b"99999999", b"1e30", b"nan"]
WORDS = [b"\0\0\0\0", b"\xff\xff\xff\xff", b"\x7f\xff\xff\xff", b"\xff\xff\xff\x7f", b"\x80\0\0\0", b"\0\0\0\x80", b"\x01\0\0\0"]


def swap_number(rng, data):
    """Replaces one number of a text."""
    numbers = list(re.finditer(rb"-?\d+(\.\d+)?", data))
    if not numbers:
        return data
    found = rng.choice(numbers)
    return data[:found.start()] + rng.choice(NUMBERS) + data[found.end():]


def put_word(rng, data):
    at = rng.randrange(max(1, len(data) - 4))
    return data[:at] + rng.choice(WORDS) + data[at + 4:]


def flip_bits(rng, data):
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def cut_off(rng, data):
    return data[:rng.randrange(1, len(data))]


def leave_out(rng, data):
    at, count = rng.randrange(len(data)), rng.choice((1, 4, 8, 100))
    return data[:at] + data[at + count:]


def repeat(rng, data):
    at, count = rng.randrange(len(data)), rng.choice((1, 4, 64, 512))
    return data[:at + count] + data[at:at + count] + data[at + count:]


def swap_line(rng, data):
    """Replaces a line by another one of the text."""
    lines = data.split(b"\n")
    lines[rng.randrange(len(lines))] = rng.choice(lines)
    return b"\n".join(lines)


def mutate(data, seed):
    """Returns `data` with one to three kinds of damage."""
    rng = random.Random(seed)
    kinds = (swap_number, swap_number, put_word, put_word, flip_bits, cut_off, leave_out, repeat, swap_line)
    for _ in range(rng.choice((1, 1, 2, 3))):
        data = rng.choice(kinds)(rng, data) or b"\n"
    return data
