// The cause and the remedy of each note, for `isoextract help notes` and docs/messages.md.
#pragma once

#include <span>
#include <string_view>

#include "base/note.hpp"

namespace isoextract::cli {

struct NoteGuide {
  NoteId id;
  std::string_view cause;   // a sentence
  std::string_view remedy;  // a sentence; empty: nothing needs to be done
};

// Returns one entry for each id, in the order of the ids.
[[nodiscard]] std::span<const NoteGuide> note_guide();

}  // namespace isoextract::cli
