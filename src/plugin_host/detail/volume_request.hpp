// The request and the selection of a volume as the plug-in's C interface has them.
#pragma once

#include <span>

#include <volume_plugin.h>
#include "plugin_host/plugin_session.hpp"

namespace isoextract::plugin_host {

// Refers to `input` and `files`, which must live longer.
class VolumeRequest {
 public:
  VolumeRequest(const VolumeInput& input, std::span<const char* const> files);
  [[nodiscard]] const isoextract_volume_request& get() const { return request_; }

 private:
  isoextract_volume_request request_{};
};

// `box` receives the samples of a full box.
[[nodiscard]] isoextract_volume_selection selection_of(const VolumeSelection& wanted, void* box);

}  // namespace isoextract::plugin_host
