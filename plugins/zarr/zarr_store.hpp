// Where the keys and values of a Zarr hierarchy are: a folder with a file for each key, or a ZIP file with a member for
// each. Keys are paths with '/' (Zarr v3 core specification, "Stores"; v2 specification, "Storage").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volume_reader.hpp"

namespace isoextract_zarr {

using Bytes = std::vector<std::byte>;
using isoextract_plugin::ReadError;

// The bytes of one key. Safe to read from several threads.
class Value {
 public:
  explicit Value(std::uint64_t size) : size_(size) {}
  Value(const Value&) = delete;
  Value& operator=(const Value&) = delete;
  virtual ~Value() = default;

  [[nodiscard]] std::uint64_t size() const { return size_; }
  // Reads to.size() bytes from `offset` on. Throws if the value ends before.
  void read(std::uint64_t offset, std::span<std::byte> to) const;

 private:
  virtual void read_checked(std::uint64_t offset, std::span<std::byte> to) const = 0;
  std::uint64_t size_;
};

// All functions are safe to call from several threads.
class Store {
 public:
  Store() = default;
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;
  virtual ~Store() = default;

  // Returns null if the key is absent. Throws if it is there but cannot be read, such as a named pipe.
  [[nodiscard]] virtual std::unique_ptr<Value> find(const std::string& key) const = 0;
  // Returns the sorted names of the folders directly below a group; "" is the root.
  [[nodiscard]] virtual std::vector<std::string> folders(const std::string& group) const = 0;
  // Returns the path that the key's own file has or would have; "" in a ZIP file.
  [[nodiscard]] virtual std::string file_of(const std::string& key) const = 0;
  // Returns a text that is equal for two names of one folder, so that loops of symbolic links can be found.
  [[nodiscard]] virtual std::string identity(const std::string& group) const { return group; }
};

// Returns whether a file with this name makes a folder or ZIP file known as Zarr.
[[nodiscard]] bool is_metadata_name(std::string_view name);

// Opens a folder, or the folder of a metadata file, or a ZIP file, whose directory stays in `memory`.
[[nodiscard]] std::unique_ptr<Store> open_store(const std::string& path, isoextract_plugin::HostMemory& memory);

// Returns whether a ZIP file has a member with the name of a metadata file.
[[nodiscard]] bool zip_has_metadata(const std::string& path);

// Returns `text` for messages: at most 100 characters, then "..." if there are more; '?' for all but printable ASCII.
[[nodiscard]] std::string shown(std::string_view text);

// Joins two paths with '/'; either may be empty.
[[nodiscard]] std::string join(const std::string& group, const std::string& name);

// Normalizes a path in the metadata of a hierarchy. Throws if it leaves the hierarchy or is no path.
[[nodiscard]] std::string checked_path(const std::string& path);

}  // namespace isoextract_zarr
