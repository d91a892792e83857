"""The files of a sequence: which there are, and which one belongs to a frame.

A pattern is a file name in which `{}` stands for the frame's number, with or without leading zeros: `smoke_{}.glb`.
A pattern without `{}` is one file that stays.
"""

import bisect
import dataclasses
import functools
import math
import os
import re

from .surface import UnreadableFile

NUMBER = "{}"
EXTENSIONS = (".glb", ".ply")


def pattern_of(folder, name):
    """The pattern that a file belongs to. Of several numbers in its name, the one that differs in most files."""
    if NUMBER in name:
        raise UnreadableFile(f"{name}: '{NUMBER}' in the name of a file cannot be told from a pattern")
    stem, extension = os.path.splitext(name)
    patterns = [stem[:number.start()] + NUMBER + stem[number.end():] + extension
                for number in re.finditer(r"\d+", stem)]
    if not patterns:
        return name
    # The last of equals: mesh2_0001 counts frames at its end.
    return max(reversed(patterns), key=lambda pattern: len(Sequence.in_folder(folder, pattern).numbers))


@dataclasses.dataclass(frozen=True)
class Sequence:
    """The files of a pattern in the order of their numbers, which may have gaps."""

    folder: str
    numbers: tuple
    names: tuple

    @staticmethod
    def in_folder(folder, pattern):
        """The files of the sequence in the folder. Lists the folder again only if it changed."""
        try:
            changed = os.stat(folder).st_mtime_ns
        except OSError as error:
            raise UnreadableFile(f"{folder}: {error.strerror or error}") from error
        return _listed(folder, pattern, changed)

    def number_at(self, frame, start, first, last, loops):
        """The number whose file a scene's frame shows: the highest of those that are not above the frame's.

        The first of the numbers from `first` to `last` is shown at scene frame `start`. Before it and after the last
        one the ends are held, or the sequence repeats. None: there is no file.
        """
        numbers = self.numbers[bisect.bisect_left(self.numbers, first):bisect.bisect_right(self.numbers, last)]
        if not numbers:
            return None
        wanted = numbers[0] + frame - start
        if loops:
            # The last frame lasts as long as the shortest step between two others.
            step = functools.reduce(math.gcd, (b - a for a, b in zip(numbers, numbers[1:])), 0) or 1
            wanted = numbers[0] + (frame - start) % (numbers[-1] - numbers[0] + step)
        return numbers[max(0, bisect.bisect_right(numbers, wanted) - 1)]

    def path(self, number):
        return os.path.join(self.folder, self.names[self.numbers.index(number)])

    def missing(self):
        """How many numbers are missing between the first and the last, where every other one is there."""
        step = functools.reduce(math.gcd, (b - a for a, b in zip(self.numbers, self.numbers[1:])), 0) or 1
        return (self.numbers[-1] - self.numbers[0]) // step + 1 - len(self.numbers) if self.numbers else 0


@functools.lru_cache(maxsize=64)
def _listed(folder, pattern, _changed):
    if NUMBER not in pattern:
        is_there = os.path.isfile(os.path.join(folder, pattern))
        return Sequence(folder, (0,) if is_there else (), (pattern,) if is_there else ())
    before, _, after = pattern.partition(NUMBER)
    form = re.compile(re.escape(before) + r"(\d+)" + re.escape(after))
    found = {}
    with os.scandir(folder) as entries:
        for entry in sorted(entries, key=lambda entry: entry.name):
            match = form.fullmatch(entry.name)
            if match:
                found.setdefault(int(match.group(1)), entry.name)
    numbers = tuple(sorted(found))
    return Sequence(folder, numbers, tuple(found[number] for number in numbers))


def sequences_of(folder, names):
    """[(pattern, first number, last number)] of the chosen files: one file stands for all of its sequence, several for
    those from the lowest to the highest of their numbers."""
    chosen = {}
    for name in names:
        chosen.setdefault(pattern_of(folder, name), []).append(name)
    found = []
    for pattern, members in sorted(chosen.items()):
        sequence = Sequence.in_folder(folder, pattern)
        if not sequence.numbers:
            raise UnreadableFile(f"{os.path.join(folder, members[0])}: there is no such file")
        numbers = sequence.numbers
        if len(members) > 1:
            numbers = sorted(number for number, name in zip(sequence.numbers, sequence.names) if name in members)
        found.append((pattern, numbers[0], numbers[-1]))
    return found
