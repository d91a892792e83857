// What `check` found out, as a table, as sentences and as JSON.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check/mesh_check.hpp"
#include "convert/json_type.hpp"
#include "convert/placement.hpp"

namespace isoextract::cli {

// One mesh of a file of several.
struct PartReport {
  std::string name;  // as the file has it; may be empty
  check::MeshCheck check;
};

struct CheckReport {
  std::string file;
  std::string_view format;
  bool is_gltf = false;
  std::optional<convert::LengthUnit> unit;  // that glTF prescribes, or that the file says; else nobody knows
  bool has_normals = false;                 // one mesh of it at least
  bool welded = false;
  check::MeshCheck whole;
  std::vector<PartReport> parts;  // none where the file holds one mesh
  std::vector<check::Requirement> required;
};

// What those who use the mesh next would make of it.
struct Finding {
  std::string_view who;  // "slicer", "engine"
  std::string text;      // a sentence
};
[[nodiscard]] std::vector<Finding> findings_of(const CheckReport& report);

[[nodiscard]] std::string check_text(const CheckReport& report);
[[nodiscard]] convert::Json check_json(const CheckReport& report);

}  // namespace isoextract::cli
