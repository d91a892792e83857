// Finds the box on whose faces the caps must stay when a stage moves vertices.
#pragma once

#include <optional>

#include "convert/stages/surface_stages.hpp"
#include "edit/smooth.hpp"

namespace isoextract::convert {

// Returns the box of samples whose outer faces the caps of the surface lie on; nullopt without such caps.
[[nodiscard]] std::optional<edit::DataBox> box_of_caps(const StageContext& stage);

}  // namespace isoextract::convert
