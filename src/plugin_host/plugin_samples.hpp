// What goes between plug-ins and fields (plugins/plugin_samples.h): types of samples, sparse samples, and memory.
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

// Nothing for ISOEXTRACT_NOT_SCALAR and what is not known.
[[nodiscard]] std::optional<field::SampleType> sample_type_of(std::int32_t type);
[[nodiscard]] std::int32_t plugin_type_of(field::SampleType type);

// A text of a plug-in, which may be null.
[[nodiscard]] inline std::string plugin_text(const char* text) { return text == nullptr ? "" : text; }

// Three rows of four, as plug-ins have them.
[[nodiscard]] field::Affine affine_of(const double* index_to_world);
[[nodiscard]] std::array<double, 12> plugin_rows_of(const field::Affine& affine);

// The memory that a plug-in asks for during a call. What it has not given back then stays reserved for as long as this
// lives. The context outlives the call.
class PluginMemory {
 public:
  // `what` starts the message where there is not enough.
  PluginMemory(const Context& context, std::string what);
  PluginMemory(const PluginMemory&) = delete;
  PluginMemory& operator=(const PluginMemory&) = delete;

  [[nodiscard]] const isoextract_plugin_host& host() const { return host_; }

  // Reserves `bytes` for as long as this lives; release() does not give them back. False where there are not enough.
  [[nodiscard]] bool hold(std::uint64_t bytes);

  // Why the call has failed where that is no fault of the plug-in's or of what it read: `otherwise` if it is.
  [[nodiscard]] Error failure_or(Error otherwise) const;

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

// Sparse samples of a plug-in as those of a field. Their values stay where they are, kept alive by `owner`. The lists
// of blocks and tiles are copied. Fails with what is wrong with them, as the end of a sentence: "blocks that are not in
// order".
[[nodiscard]] tl::expected<field::SparseSamples, std::string> sparse_samples_of(const isoextract_sparse_samples& given,
                                                                                std::shared_ptr<const void> owner);

// And back; the lists refer to the field's values.
struct PluginSparse {
  std::vector<isoextract_sparse_block> blocks;
  std::vector<isoextract_sparse_tile> tiles;
  isoextract_sparse_samples samples{};
};
[[nodiscard]] std::unique_ptr<const PluginSparse> plugin_sparse_of(const field::SparseSamples& samples);

}  // namespace isoextract::plugin_host
