#include "batch/batch_job.hpp"

#include <fmt/format.h>

#include "files/content_hash.hpp"

namespace isoextract::batch {

std::string hash_of(const BatchJob& batch) {
  std::string text;
  for (const FrameJob& frame : batch.frames) text += fmt::format("{} {}\n", frame.number, convert::hash_of(frame.job));
  if (batch.animation) text += fmt::format("{} {}\n", batch.animation->frames_per_second, batch.animation->path);
  return files::content_hash(text);
}

}  // namespace isoextract::batch
