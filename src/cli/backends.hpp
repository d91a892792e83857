// The backends by name.
#pragma once

#include <memory>
#include <string_view>

#include "base/error.hpp"
#include "extract/extractor.hpp"

namespace isoextract {

enum class Backend { cpu, gpu };

[[nodiscard]] std::string_view backend_name(Backend backend);  // "cpu"

// Fails with ErrorKind::unavailable where this build or this machine does not have it.
[[nodiscard]] Result<std::unique_ptr<Extractor>> open_backend(Backend backend);

}  // namespace isoextract
