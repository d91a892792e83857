#include "cli/up_axis_note.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"
#include "convert/field_label.hpp"

namespace isoextract::cli {
namespace {

constexpr std::size_t kMaxShownCreator = 40;  // bytes

}  // namespace

std::optional<Note> up_axis_note(const field::ScalarField& field, convert::UpAxis up, std::string_view consequence) {
  const auto made_with = convert::up_axis_of(field.creator);
  if (!made_with || *made_with == up) return std::nullopt;
  const std::string creator = printable(field.creator, kMaxShownCreator);
  const std::string origin = creator.ends_with("format") ? "the file has " + creator : creator + " wrote the file";
  return Note{NoteId::up_axis, fmt::format("{}: {}, whose up axis is {}, but isoextract assumes {}: {}; add --up {}",
                                           convert::field_label(field), origin, word_of(*made_with), word_of(up),
                                           consequence, word_of(*made_with))};
}

}  // namespace isoextract::cli
