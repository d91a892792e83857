#include "convert/detail/conversion_backends.hpp"

#include <utility>

#include <fmt/format.h>

namespace isoextract::convert {

Result<void> ConversionBackends::open() {
  outcome_.backend = word_of(job_.backend.backend);
  const Stopwatch watch;
  gpu::GpuOptions gpu{job_.backend.gpu};
  gpu.keep_samples = job_.isos().size() > 1;
  const auto open_one = [&](Backend backend) {
    return kept_ != nullptr ? kept_->open(backend, gpu) : open_backend(backend, gpu);
  };
  auto opened = open_one(job_.backend.backend);
  if (!opened) return tl::unexpected(std::move(opened.error()));
  extract_with(std::move(*opened), watch.elapsed());
  if (!job_.verify) return {};
  opened = open_one(extractor_->name() == word_of(Backend::gpu) ? Backend::cpu : Backend::gpu);
  if (!opened) return tl::unexpected(std::move(opened.error()));
  other_ = std::move(opened->extractor);
  return {};
}

bool ConversionBackends::fall_back_to_cpu(const Error& error) {
  if (extractor_ == nullptr) return false;
  const bool may =
      job_.backend.backend == Backend::automatic && extractor_->name() == word_of(Backend::gpu) && other_ == nullptr;
  if (!may || error.code != ErrorCode::unavailable) return false;
  extract_with({extract::make_cpu_extractor(), fmt::format("cpu, because {}", error.message)}, {});
  return true;
}

Result<void> ConversionBackends::require(extract::Method method) {
  if (extractor_->has(method)) return {};
  Error error{ErrorCode::unavailable,
              fmt::format("the {} backend does not have {}", extractor_->name(), extract::method_info(method).title),
              {Remedy::use, Setting::cpu_backend}};
  return fall_back_to_cpu(error) ? Result<void>() : tl::unexpected(std::move(error));
}

void ConversionBackends::extract_with(OpenedBackend backend, const StageTime& time) {
  extractor_ = std::move(backend.extractor);
  outcome_.backend = extractor_->name();
  outcome_.device = extractor_->device();
  if (outcome_.backend == word_of(Backend::gpu)) {
    StageReport report(StageName::open, outcome_.device);
    report.time = time;
    events_.end(report);
  }
  if (!backend.reason.empty()) events_.note({NoteId::backend, "backend: " + backend.reason});
}

}  // namespace isoextract::convert
