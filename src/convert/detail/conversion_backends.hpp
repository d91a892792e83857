// The backends of one conversion: the one that extracts, and the one that verification compares it with.
#pragma once

#include <memory>

#include "base/error.hpp"
#include "base/stopwatch.hpp"
#include "convert/backends.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/recorder.hpp"
#include "convert/outcome.hpp"
#include "extract/extractor.hpp"

namespace isoextract::convert {

class ConversionBackends {
 public:
  // With `kept`, opens backends through it; null: opens its own. All references must outlive this object.
  ConversionBackends(const ConversionJob& job, Outcome& outcome, Recorder& events, BackendCache* kept)
      : job_(job), outcome_(outcome), events_(events), kept_(kept) {}

  // Opens the job's backend, and with verification the other one. Call it before the input is read, so that a missing
  // GPU is reported at once. Fails as open_backend() does.
  [[nodiscard]] Result<void> open();

  // Falls back to the CPU, with a note, if Backend::automatic chose a GPU and `error` is ErrorCode::unavailable. Never
  // does so when verifying. Returns whether it fell back.
  bool fall_back_to_cpu(const Error& error);

  // Fails, or falls back to the CPU, if the backend does not have the method. Call it after open().
  [[nodiscard]] Result<void> require(extract::Method method);

  // Returns null before open(), and for jobs that extract nothing.
  [[nodiscard]] extract::Extractor* extractor() const { return extractor_.get(); }
  // Returns null without verification.
  [[nodiscard]] extract::Extractor* other() const { return other_.get(); }

 private:
  // Uses `backend` for all extractions from now on.
  void extract_with(OpenedBackend backend, const StageTime& time);

  const ConversionJob& job_;
  Outcome& outcome_;
  Recorder& events_;
  BackendCache* kept_;
  std::unique_ptr<extract::Extractor> extractor_;
  std::unique_ptr<extract::Extractor> other_;
};

}  // namespace isoextract::convert
