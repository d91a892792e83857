// Owns a JSON document of bounded depth whose destructor allocates nothing. The destructor of nlohmann::json allocates
// memory for nested values, and terminates the program if there is none.
#pragma once

#include <utility>

#include <nlohmann/json.hpp>

namespace isoextract::mesh_io {

class JsonTree {
 public:
  explicit JsonTree(nlohmann::json root) noexcept : root_(std::move(root)) {}
  JsonTree(const JsonTree&) = delete;
  JsonTree& operator=(const JsonTree&) = delete;
  ~JsonTree();  // NOLINT(bugprone-exception-escape)

  [[nodiscard]] nlohmann::json& root() { return root_; }

 private:
  nlohmann::json root_;
};

}  // namespace isoextract::mesh_io
