// The stage that smooths a mesh.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/json_values.hpp"
#include "convert/surface_edits.hpp"
#include "field/affine.hpp"
#include "field/samples.hpp"

namespace isoextract::convert {

struct SmoothRecord {
  double iso = 0;
  SmoothChoice asked;
  edit::SmoothFacts facts;
  std::string grid = {};  // whose surface it is, where the job has several

  // By how much of itself the volume changed; 0 where there was none.
  [[nodiscard]] double volume_change() const {
    return facts.volume_before != 0 ? facts.volume_after / facts.volume_before - 1 : 0;
  }
};
[[nodiscard]] Json json_of(const SmoothRecord& record);

// `mesh` was placed by `output_from_index`. Where it was capped, `data` are the samples it was made of: its caps lie on
// the sides of that box, and stay there; so do those of `cuts`. Fails as edit::smooth() does.
[[nodiscard]] Result<SmoothRecord> smooth_mesh(mesh::Mesh& mesh, double iso, const SmoothChoice& choice,
                                               const field::Affine& output_from_index,
                                               const std::optional<field::IndexBox>& data,
                                               std::span<const mesh::HalfSpace> cuts, const Context& context);

}  // namespace isoextract::convert
