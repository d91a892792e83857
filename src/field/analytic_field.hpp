// Exact facts about demo fields: value and gradient at any position, and the area and volume of the surface.
#pragma once

#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "field/demo_formulas.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

struct SurfaceSize {
  double area = 0;
  double volume = 0;  // of the region where the value is above iso
};

// A formula on the cube [-1, 1]^3, in the demo fields' world coordinates.
struct AnalyticField {
  std::string_view name;  // as in demo:NAME
  double (*value)(const glm::dvec3& p);
  Dual (*value_and_gradient)(const glm::dvec3& p);
  bool is_distance;  // |value - iso| is the distance to the surface, for every iso that `size` supports
  // Returns the closed-form size. Returns nothing if there is no closed form, if iso has no surface, or if the surface
  // is not entirely inside the cube.
  std::optional<SurfaceSize> (*size)(double iso);
  // Returns the length above iso of the segment from (x, y, -1) to (x, y, 1), in closed form. The pointer is null if
  // there is no closed form.
  double (*inside_length_along_z)(double x, double y, double iso);
  // True: each such segment is above iso from z = -1 up to z = -1 + inside_length_along_z, and crosses the surface
  // there only.
  bool is_graph_over_z;
};

// Returns null for unknown names, and for demo fields without a formula, such as random.
[[nodiscard]] const AnalyticField* find_analytic_field(std::string_view demo_name);

// Returns the formula that a demo field was made from. Null for other fields, for demo fields without a formula, and
// for a time other than 0. Reads only name, format and source, so it also returns the formula of a filtered demo field.
[[nodiscard]] const AnalyticField* find_formula(const ScalarField& field);

}  // namespace isoextract::field
