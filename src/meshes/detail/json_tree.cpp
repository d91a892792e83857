#include "meshes/detail/json_tree.hpp"

namespace isoextract::meshes {
namespace {

// From the leaves up, so that nothing is nested any more.
void empty(nlohmann::json& value) noexcept {
  if (!value.is_structured()) return;
  for (nlohmann::json& inner : value) empty(inner);
  value.clear();
}

}  // namespace

JsonTree::~JsonTree() { empty(root_); }

}  // namespace isoextract::meshes
