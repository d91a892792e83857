#include "mesh_io/detail/json_tree.hpp"

namespace isoextract::mesh_io {
namespace {

// From the leaves up, so that nothing is nested any more. Of what is structured neither iterators nor clear() throw.
void empty(nlohmann::json& value) noexcept {  // NOLINT(bugprone-exception-escape)
  if (!value.is_structured()) return;
  for (nlohmann::json& inner : value) empty(inner);
  value.clear();
}

}  // namespace

JsonTree::~JsonTree() { empty(root_); }  // NOLINT(bugprone-exception-escape)

}  // namespace isoextract::mesh_io
