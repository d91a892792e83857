// Converts sample types, transforms and sparse samples between plug-ins (plugins/plugin_samples.h) and fields, and
// gives plug-ins memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <plugin_samples.h>
#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "field/samples.hpp"

namespace isoextract::plugin_host {

// Returns nothing for ISOEXTRACT_NOT_SCALAR and unknown types.
[[nodiscard]] std::optional<field::SampleType> sample_type_of(std::int32_t type);
[[nodiscard]] std::int32_t plugin_type_of(field::SampleType type);

// Returns a plug-in's text; "" for null.
[[nodiscard]] inline std::string plugin_text(const char* text) { return text == nullptr ? "" : text; }

// Converts the 12 numbers of the plug-in interface, three rows of four, to an index-to-world transform, and back.
[[nodiscard]] field::Affine affine_of(const double* index_to_world);
[[nodiscard]] std::array<double, 12> plugin_rows_of(const field::Affine& affine);

// Memory that a plug-in requests during a call, also from several threads. Anything it does not release stays reserved
// for the lifetime of this object, which must outlive the call.
class PluginMemory {
 public:
  // `what` starts the message if memory does not suffice.
  PluginMemory(const Context& context, std::string what);
  PluginMemory(const PluginMemory&) = delete;
  PluginMemory& operator=(const PluginMemory&) = delete;

  [[nodiscard]] const isoextract_plugin_host& host() const { return host_; }

  // Reserves `bytes` for the lifetime of this object; host().release() does not return them. Returns false if memory
  // does not suffice, or did not for an earlier request of this object.
  [[nodiscard]] bool hold(std::uint64_t bytes);

  // Returns why the call failed: the cancellation or the lack of memory that it met, if any; else `otherwise`, the
  // fault of the plug-in or its input.
  [[nodiscard]] Error refusal_or(Error otherwise) const;

 private:
  bool reserve(std::uint64_t bytes);
  void* allocate(std::uint64_t bytes);
  void release(std::uint64_t bytes);

  Context context_;
  std::string what_;
  isoextract_plugin_host host_;
  mutable std::mutex mutex_;
  std::vector<Reservation> parts_;
  std::vector<Reservation> held_;
  std::vector<Buffer<std::byte>> blocks_;
  std::optional<Error> refusal_;
};

// Converts a plug-in's sparse samples. Copies the lists of blocks and tiles, but no tiles of the background's value;
// the values stay in place, kept alive by `owner`. The error completes the sentence "the plug-in returns ...": "blocks
// that are not in order". Does not check whether tiles overlap, nor the box and number of active voxels.
[[nodiscard]] tl::expected<field::SparseSamples, std::string> sparse_samples_of(const isoextract_sparse_samples& given,
                                                                                std::shared_ptr<const void> owner);

// The reverse conversion. `samples` refers to the lists, and the blocks refer to the field's values, which must live
// longer.
struct PluginSparse {
  std::vector<isoextract_sparse_block> blocks;
  std::vector<isoextract_sparse_tile> tiles;
  isoextract_sparse_samples samples{};
};
[[nodiscard]] std::unique_ptr<const PluginSparse> plugin_sparse_of(const field::SparseSamples& samples);

}  // namespace isoextract::plugin_host
