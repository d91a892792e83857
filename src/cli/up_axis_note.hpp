// Makes a note if the program that created a volume uses another up axis than the command.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/note.hpp"
#include "convert/placement.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

// Returns a note if the program or format that made the field has another up axis than `up`; nullopt if it has `up` or
// its up axis is unknown. `consequence` is the effect on the output: "the mesh lies on its side".
[[nodiscard]] std::optional<Note> up_axis_note(const field::ScalarField& field, convert::UpAxis up,
                                               std::string_view consequence);

}  // namespace isoextract::cli
