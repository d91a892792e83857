// What is known of demo fields besides their samples: value and gradient anywhere, and the true size of their surface.
#pragma once

#include <optional>
#include <string_view>

#include <glm/glm.hpp>

#include "field/demo_formulas.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

struct SurfaceSize {
  double area = 0;
  double volume = 0;  // of where the value is above iso
};

// On the cube [-1, 1]^3, in the coordinates of the demo fields' world.
struct AnalyticField {
  std::string_view name;  // as in demo:NAME
  double (*value)(const glm::dvec3& p);
  Dual (*value_and_gradient)(const glm::dvec3& p);
  bool is_distance;  // |value - iso| is the distance to the surface at iso, for all iso that `size` knows
  // In closed form; nothing where there is none, or where the surface at iso is not wholly inside the cube.
  std::optional<SurfaceSize> (*size)(double iso);
  // How much of the line through (x, y, -1) and (x, y, 1) is above iso, in closed form; null where there is none.
  double (*length_along_z)(double x, double y, double iso);
  bool is_graph_over_z;  // each of those lines meets the surface once at most, where that length ends
};

// Null for names without a formula, such as random.
[[nodiscard]] const AnalyticField* find_analytic_field(std::string_view demo_name);

// That of the samples of a demo field; null for other fields, and for one that has moved: formulas are those at time 0.
[[nodiscard]] const AnalyticField* formula_of(const ScalarField& field);

}  // namespace isoextract::field
