// The groups and arrays of a Zarr hierarchy, v2 or v3, with their metadata.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "zarr_metadata.hpp"
#include "zarr_store.hpp"

namespace isoextract_zarr {

struct Node {
  bool is_array = false;
  int zarr_format = 2;
  Json metadata;    // .zarray or zarr.json
  Json attributes;  // .zattrs, or "attributes" in zarr.json; null if there are none
};

// Reads metadata on demand. Use it from one thread at a time.
class Hierarchy {
 public:
  // Reads the consolidated metadata of the root, if there are any. The store and the host must live as
  // long as this object, which keeps memory reserved for all metadata that it has read.
  Hierarchy(const Store& store, const isoextract_plugin_host& host);

  // Returns nothing if the path has neither a group nor an array. Throws if the metadata are not a valid JSON object,
  // or have another Zarr version or type of node.
  [[nodiscard]] std::optional<Node> find(const std::string& path);
  // Throws unless the path has an array with valid metadata.
  [[nodiscard]] ArrayMetadata array(const std::string& path);
  // Returns the names of the folders and consolidated nodes directly below a group. Not all need be nodes: see find().
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const;

  [[nodiscard]] const Store& store() const { return store_; }
  [[nodiscard]] const isoextract_plugin_host& host() const { return host_; }
  // Returns the files with metadata that this object has read.
  [[nodiscard]] const std::set<std::string>& files() const { return files_; }

 private:
  [[nodiscard]] std::optional<Json> read_json(const std::string& key);
  void read_consolidated();

  const Store& store_;
  const isoextract_plugin_host& host_;
  isoextract_plugin::HostMemory memory_;
  std::map<std::string, Json> consolidated_;  // by key
  std::set<std::string> files_;
};

// Returns the metadata of a node that is an array. Throws if they are not valid.
[[nodiscard]] ArrayMetadata parse_array(const Node& node);

}  // namespace isoextract_zarr
