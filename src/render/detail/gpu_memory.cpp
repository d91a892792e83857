#include "render/detail/gpu_memory.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/byte_size.hpp"

namespace isoextract::render::detail {

GpuMemory::GpuMemory(const gl::GpuDevice& device, std::optional<std::uint64_t> limit, std::uint64_t besides,
                     const Context& context)
    : device_(device), context_(context), limit_(limit), is_told_(limit.has_value()), taken_(besides) {
  if (!limit_ && device.memory_bytes) limit_ = *device.memory_bytes / 4 * 3;
}

Result<void> GpuMemory::take(std::uint64_t bytes, const std::string& what) {
  if (limit_ && bytes > *limit_ - taken_) {
    return fail(ErrorCode::unavailable,
                fmt::format("{}: the GPU memory limit is {}: {} would take {}, and {} are in use", device_.renderer,
                            format_byte_size(*limit_), what, format_byte_size(bytes), format_byte_size(taken_)),
                is_told_ ? Hint{{Remedy::raise, Setting::gpu_memory}, {Remedy::use, Setting::cpu_backend}}
                         : Hint(Remedy::use, Setting::cpu_backend));
  }
  if (device_.software) {
    auto memory = TRY(context_.reserve(bytes, what));
    memory_.take(std::move(memory));
  }
  taken_ += bytes;
  return {};
}

}  // namespace isoextract::render::detail
