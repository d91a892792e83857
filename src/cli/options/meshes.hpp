// The options of the commands that read meshes: compare and check.
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

  Values<std::string> meshes{in(OptionGroup::input), "MESH", "MESH", parse_text,
                             fmt::format("The two meshes. Formats: {}. Vertices at equal coordinates are merged in "
                                         "formats without connectivity, such as stl.",
                                         mesh_io::mesh_extensions())};
  Value<convert::UpAxis> up{
      in(OptionGroup::input), "--up",
      "Up axis of the mesh that is not glTF (default: z). It counts where one mesh is glb or gltf and the other is "
      "not, or where only one of two such files records its placement: glTF prescribes y up, the other formats "
      "nothing. With z, compare turns the glTF mesh back, (x, y, z) to (x, -z, y), and the result says so. Use y for a "
      "glTF mesh of another program that has the axes of the other mesh."};
  MemoryLimit memory_limit{in(OptionGroup::input)};
  Value<double> max_distance{in(OptionGroup::output), "--max-distance", "D", parse_not_negative,
                             "Largest distance allowed; else exit with code 6. At any point of either mesh, in the "
                             "unit of the meshes, or of their source world if compare undoes their placement."};
  JsonFlag json{in(OptionGroup::output)};
  RunFlags run{*this};
};

// Parses words separated by commas: requirements, and "printable" for all that a slicer needs. Repetition is allowed;
// the result has each requirement once. Fails with ErrorCode::usage.
[[nodiscard]] Result<std::vector<check::Requirement>> parse_requirements(std::string_view text);
// Returns "closed, manifold, ...; or printable, which is closed, ...".
[[nodiscard]] std::string requirement_list();

struct CheckFlags : OptionSet {
  CheckFlags();

  Values<std::string> meshes{
      in(OptionGroup::input), "MESH", "MESH", parse_text,
      fmt::format(
          "Mesh to check, or - for stdin. Formats: {}. Vertices at equal coordinates are merged in formats without "
          "connectivity, such as stl. In a glTF file with several meshes, check tests each mesh, then all of them as "
          "one.",
          mesh_io::mesh_extensions())};
  Flag weld{in(OptionGroup::input), "--weld",
            "Merge vertices at equal coordinates first. Slicers do so. Without --weld the report tells how many edges "
            "would stay open after merging."};
  MemoryLimit memory_limit{in(OptionGroup::input)};
  Value<std::vector<check::Requirement>> required{
      in(OptionGroup::output), "--require", "WORD,WORD,...", parse_requirements,
      fmt::format("Properties the mesh must have; else exit with code 6. Any of {}.", requirement_list())};
  JsonFlag json{in(OptionGroup::output)};
  Value<std::string> report{in(OptionGroup::output), "--report", "FILE", parse_text,
                            "Write the JSON into a file as well."};
  RunFlags run{*this};
};

}  // namespace isoextract::cli
