// OpenVDB's maps. Each is stored as a name and its members as doubles. Matrices multiply row vectors, so row a of a
// matrix is the image of axis a. Scale maps also store four vectors derived from the scale.
#include "volume_io/vdb/vdb_transform.hpp"

#include <array>
#include <string>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::string_view kFrustum = "NonlinearFrustumMap";

Frame read_matrix(VdbCursor& cursor) {
  const auto rows = cursor.read_value<std::array<std::array<double, 4>, 4>>();
  Frame frame;
  for (int axis = 0; axis < 3; ++axis) {
    for (int c = 0; c < 3; ++c) frame.index_to_world.linear[axis][c] = rows[static_cast<std::size_t>(axis)][c];
    frame.index_to_world.offset[axis] = rows[3][static_cast<std::size_t>(axis)];
  }
  if (rows[0][3] != 0 || rows[1][3] != 0 || rows[2][3] != 0 || rows[3][3] != 1) {
    frame.problem = "expected a linear transform, found a projection";
  }
  return frame;
}

Frame read_scale(VdbCursor& cursor) {
  const auto vectors = cursor.read_value<std::array<glm::dvec3, 5>>();
  return {field::scaling(vectors[0]), {}};
}

Frame read_linear_map(VdbCursor& cursor, const std::string& name) {
  if (name == "AffineMap" || name == "UnitaryMap") return read_matrix(cursor);
  if (name == "ScaleMap" || name == "UniformScaleMap") return read_scale(cursor);
  Frame frame;
  const bool scales = name == "ScaleTranslateMap" || name == "UniformScaleTranslateMap";
  if (!scales && name != "TranslationMap") {
    throw UnsupportedVdb(fmt::format("expected a linear transform, found '{}'", printable(name, 80)));
  }
  const auto offset = cursor.read_value<glm::dvec3>();
  if (scales) frame = read_scale(cursor);
  frame.index_to_world.offset = offset;
  return frame;
}

}  // namespace

VdbPlacement read_vdb_transform(VdbCursor& cursor) {
  const std::string name = cursor.read_name();
  if (name == kFrustum) {
    // A box of six doubles, taper and depth; then the frustum's linear map.
    static_cast<void>(cursor.take(8 * sizeof(double)));
    const std::string second = cursor.read_name();
    VdbPlacement frame{read_linear_map(cursor, second), true};
    frame.problem = fmt::format("expected a linear transform, found {}", kFrustum);
    return frame;
  }
  VdbPlacement frame{read_linear_map(cursor, name)};
  if (frame.problem.empty() && !frame.index_to_world.is_invertible()) {
    frame.problem = "expected a transform with an inverse: its matrix is singular or not finite";
  }
  return frame;
}

}  // namespace isoextract::volume_io
