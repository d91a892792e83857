// The options of the commands that look at meshes: compare and check.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "check/mesh_requirement.hpp"
#include "cli/option.hpp"
#include "cli/options/run.hpp"
#include "cli/values.hpp"
#include "convert/placement.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

struct CompareFlags : OptionSet {
  CompareFlags();

  Values<std::string> meshes{in(OptionGroup::input), "FILE", "FILE", parse_text,
                             fmt::format("The two meshes: {}. Corners without connectivity, as in stl, are welded "
                                         "where their coordinates are equal.",
                                         mesh_io::mesh_extensions())};
  Value<convert::UpAxis> up{
      in(OptionGroup::input), "--up",
      "Where one mesh is glb or gltf and the other is not: the axis that points up in the other (default: z). "
      "glTF prescribes y, and ply, obj, stl and drc nothing. With z the glTF mesh is turned, which the result "
      "tells: (x, y, z) becomes (x, -z, y), as it was before convert turned it. With y nothing is turned: "
      "for meshes that were written with --up y or --space index."};
  MemoryLimit memory_limit{in(OptionGroup::input)};
  Value<double> max_distance{
      in(OptionGroup::output), "--max-distance", "D", parse_not_negative,
      "Exit with code 6 unless no point of either mesh is farther than this from the other, in the meshes' unit."};
  JsonFlag json{in(OptionGroup::output)};
  RunFlags run{*this};
};

// Words of check::Requirement separated by commas, or "printable" for what a slicer needs; each once.
[[nodiscard]] Result<std::vector<check::Requirement>> parse_requirements(std::string_view text);
// "closed, manifold, ...; or printable, which is closed, ..."
[[nodiscard]] std::string requirement_list();

struct CheckFlags : OptionSet {
  CheckFlags();

  Values<std::string> meshes{
      in(OptionGroup::input), "FILE", "FILE", parse_text,
      fmt::format("The mesh: {}, or - for stdin. Corners without connectivity, as in stl, are welded where their "
                  "coordinates are equal. Of a glTF file with several meshes each is checked, and then all of them as "
                  "one.",
                  mesh_io::mesh_extensions())};
  Flag weld{in(OptionGroup::input), "--weld",
            "Join vertices with the same coordinates first, as slicers do. Without it they are told apart, and the "
            "report says what joining them would close."};
  MemoryLimit memory_limit{in(OptionGroup::input)};
  Value<std::vector<check::Requirement>> required{
      in(OptionGroup::output), "--require", "WORD,WORD,...", parse_requirements,
      fmt::format("Exit with code 6 unless the mesh is all of these: {}.", requirement_list())};
  JsonFlag json{in(OptionGroup::output)};
  Value<std::string> report{in(OptionGroup::output), "--report", "FILE", parse_text,
                            "Write the same JSON into a file as well."};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
