// Kinds of vertex attributes (AttributeKind): how attributes change when their mesh is moved, and how mesh files record
// them.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/attribute_kind.hpp"
#include "base/error.hpp"
#include "convert/vertex_choices.hpp"
#include "field/affine.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::convert {

struct NamedKind {
  std::string name;
  AttributeKind kind = AttributeKind::scalar;

  friend bool operator==(const NamedKind&, const NamedKind&) = default;
};

// Returns the chosen kind. Without one, returns scalar for fewer than three `components`, else the stated kind, else a
// guess from the name of the attribute or its source; nullopt without a guess. If a stated or guessed kind needs three
// components and there are more, returns scalar.
//
// Fails with ErrorCode::usage if the chosen kind needs three components and there are not three.
[[nodiscard]] Result<std::optional<AttributeKind>> find_kind(const AttributeChoice& choice, std::size_t components,
                                                             std::optional<AttributeKind> stated);

// Returns the JSON text for a mesh file's placement record, such as {"v":"vector"}. It lists only the kinds that change
// with the mesh, and is empty if there are none. In names, '_' replaces all characters but ASCII letters and digits.
[[nodiscard]] std::string kinds_text(const std::vector<NamedKind>& kinds);

// Returns the attributes of `mesh`, read from a file, that change when it is moved, with their kinds. If isoextract
// wrote the file (`is_by_isoextract`), its placement record `placement` names them all. Otherwise attribute names
// decide (kind_by_name()).
[[nodiscard]] std::vector<NamedKind> kinds_of(const mesh::Mesh& mesh, bool is_by_isoextract,
                                              std::string_view placement);

// Applies `map`, which moved the mesh, to the attributes named in `kinds`, and gives normals the length 1 even if `map`
// is the identity. Attributes with AttributeRole::color and attributes not in `kinds` do not change.
void transform_attributes(mesh::Mesh& mesh, const std::vector<NamedKind>& kinds, const field::Affine& map);

}  // namespace isoextract::convert
