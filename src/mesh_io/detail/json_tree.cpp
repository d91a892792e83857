#include "mesh_io/detail/json_tree.hpp"

namespace isoextract::mesh_io {
namespace {

// Empties values from the leaves up, so that the destructor finds no nesting. Iterators and clear() of lists and
// objects do not throw.
void empty(nlohmann::json& value) noexcept {  // NOLINT(bugprone-exception-escape)
  if (!value.is_structured()) return;
  for (nlohmann::json& inner : value) empty(inner);
  value.clear();
}

}  // namespace

JsonTree::~JsonTree() { empty(root_); }  // NOLINT(bugprone-exception-escape)

}  // namespace isoextract::mesh_io
