// Formats the results of `check` as a table, as sentences and as JSON.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check/mesh_check.hpp"
#include "convert/json_type.hpp"
#include "convert/placement.hpp"

namespace isoextract::cli {

// The results for one of several meshes of a file.
struct PartReport {
  std::string name;  // from the file; may be empty
  check::MeshCheck check;
};

struct CheckReport {
  std::string file;
  std::string_view format;
  bool is_gltf = false;
  std::optional<convert::LengthUnit> unit;  // prescribed by glTF, or stated in the file; otherwise unknown
  bool has_normals = false;                 // at least one mesh has normals
  bool welded = false;
  check::MeshCheck whole;
  std::vector<PartReport> parts;  // empty if the file holds one mesh
  std::vector<check::Requirement> required;
};

// A consequence for the next user of the mesh.
struct Finding {
  std::string_view who;  // "slicer", "engine"
  std::string text;      // a sentence
};
[[nodiscard]] std::vector<Finding> findings_of(const CheckReport& report);

[[nodiscard]] std::string check_text(const CheckReport& report);
[[nodiscard]] convert::Json check_json(const CheckReport& report);

}  // namespace isoextract::cli
