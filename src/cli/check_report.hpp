// Formats the results of `check` as text and as JSON, with sentences for users of the mesh (findings).
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
  std::optional<convert::LengthUnit> unit;  // meters for glTF, or as isoextract recorded in the file
  bool has_normals = false;                 // at least one mesh has normals
  bool welded = false;
  check::MeshCheck whole;         // of all meshes together
  std::vector<PartReport> parts;  // empty if the file holds one mesh
  std::vector<check::Requirement> required;
};

// Returns why the file does not meet the requirement ("12 open edges in 2 loops"), or nothing if it does. In a file
// with several meshes, each mesh must meet the requirement by itself, as in a conversion with --require: two
// neighboring labels both have the triangles between them.
[[nodiscard]] std::optional<std::string> unmet_reason(check::Requirement requirement, const CheckReport& report);

// A consequence of the mesh's properties for a slicer or a game engine.
struct Finding {
  std::string_view who;  // "slicer", "engine"
  std::string text;      // a sentence
};
// Returns the findings about CheckReport::whole: first for slicers, then for engines (check_findings.cpp).
[[nodiscard]] std::vector<Finding> findings_of(const CheckReport& report);

// Returns a table for the terminal with the 12 largest components and the first 12 meshes, then the findings.
[[nodiscard]] std::string check_text(const CheckReport& report);
// Returns the report with at most 1000 components and boundary loops per mesh, largest first.
[[nodiscard]] convert::Json check_json(const CheckReport& report);

}  // namespace isoextract::cli
