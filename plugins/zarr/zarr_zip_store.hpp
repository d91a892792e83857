// A Zarr hierarchy in a ZIP file, through minizip. Private to zarr_store.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "zarr_store.hpp"

namespace isoextract_zarr {

// An open file, closed with this object.
class File {
 public:
  explicit File(const std::string& path);
  File(File&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  File& operator=(File&&) = delete;
  ~File();

  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }
  // Fills `to`; `key` names the value in messages.
  void read(std::uint64_t offset, std::span<std::byte> to, const std::string& key) const;

 private:
  int number_;
};

// Opens a ZIP file. The hierarchy's root is the ZIP file's root, or its only folder if that has the metadata.
[[nodiscard]] std::unique_ptr<Store> open_zip_store(const std::string& path, isoextract_plugin::HostMemory& memory);

}  // namespace isoextract_zarr
