// Dense samples that are too large for the address space: windows bring some layers at a time into memory.
#pragma once

#include <memory>

#include "base/error.hpp"

namespace isoextract::field {

// The samples of a file, in layers: planes of equal z. Safe to use from several threads.
class SampleLayers {
 public:
  // A window of consecutive layers. For one thread; destroy it before asking DenseSamples::lost().
  class Window {
   public:
    virtual ~Window() = default;
    // Brings layers begin to end - 1 into memory, in place of those before. Returns the first sample of layer `begin`.
    // Fails with ErrorCode::out_of_memory; do not use the window afterwards. Samples that cannot be read are 0
    // (DenseSamples::loss).
    [[nodiscard]] virtual Result<const void*> move_to(int begin, int end) = 0;
  };

  virtual ~SampleLayers() = default;
  // Returns a window with room for this many layers. Fails with ErrorCode::out_of_memory if the address space is too
  // small for it. May throw std::bad_alloc.
  [[nodiscard]] virtual Result<std::unique_ptr<Window>> open(int layers) const = 0;
};

}  // namespace isoextract::field
