// What attributes of vertices mean to the placement of their mesh, and what files say of it.
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

// The kind of an attribute of so many components: the one that was chosen, else the one that the file `stated`, else by
// its name, or by that of where it comes from. Nothing where none of these says anything. Fails with ErrorCode::usage
// where a kind was chosen that needs three components.
[[nodiscard]] Result<std::optional<AttributeKind>> find_kind(const AttributeChoice& choice, std::size_t components,
                                                             std::optional<AttributeKind> stated);

// {"v":"vector"}: what files keep of those kinds that change with the mesh; empty where there are none.
[[nodiscard]] std::string kinds_text(const std::vector<NamedKind>& kinds);

// The kinds of the attributes of a mesh that was read, of those that change with it. Files of isoextract say it in
// their placement, and have no others; of other files names say it.
[[nodiscard]] std::vector<NamedKind> kinds_of(const mesh::Mesh& mesh, bool is_ours, std::string_view placement);

// Changes the attributes of a mesh that is moved by `map`. Those that are not named stay as they are.
void change_attributes(mesh::Mesh& mesh, const std::vector<NamedKind>& kinds, const field::Affine& map);

}  // namespace isoextract::convert
