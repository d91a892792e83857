// The note that a volume's creator has another axis up than the command takes.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "convert/placement.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

// Returns nothing where the axis of the creator is `up`, or is not known. `consequence` says what is wrong in the
// output: "the mesh lies on its side".
[[nodiscard]] std::optional<std::string> up_axis_note(const field::ScalarField& field, convert::UpAxis up,
                                                      std::string_view consequence);

}  // namespace isoextract::cli
