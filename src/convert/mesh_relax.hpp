// What relaxing surface nets did to volumes: thin parts lose most of theirs.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/json_values.hpp"
#include "edit/pieces.hpp"

namespace isoextract::convert {

// In the mesh's units; negative of cavities.
struct RelaxedVolume {
  double before = 0;  // of the voxels
  double after = 0;   // of the mesh

  // By how much of itself the volume changed; 0 where there was none.
  [[nodiscard]] double change() const { return before != 0 ? after / before - 1 : 0; }
  // Whether that is worth a note.
  [[nodiscard]] bool is_large() const { return std::abs(change()) > kSmallChange; }

  static constexpr double kSmallChange = 0.05;
};

struct RelaxRecord {
  double iso = 0;
  std::string surface;  // "map.npy label 7", "mask.npy iso 0.5"
  RelaxedVolume whole;
  std::uint64_t components = 0;
  std::uint64_t changed_components = 0;  // RelaxedVolume::is_large()
  RelaxedVolume worst_component;         // whose volume changed by the greatest share of itself
  std::string grid = {};                 // whose surface it is, where the job has several
};
[[nodiscard]] Json json_of(const RelaxRecord& record);

// Of a closed `mesh` whose vertices relaxing moved from `sites`. The same for any number of threads. Fails where the
// memory for it is not there.
[[nodiscard]] Result<RelaxRecord> relax_record(const mesh::Mesh& mesh, double iso, std::string surface,
                                               const edit::Sites& sites, const Context& context);

}  // namespace isoextract::convert
