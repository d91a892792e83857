#include "convert/conversion_job.hpp"

#include <cstdint>

#include <fmt/format.h>

// The hash is compiled into this file: the library is not needed when the program runs.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "convert/detail/job_json.hpp"

namespace isoextract::convert {

std::vector<double> ConversionJob::isos() const {
  std::vector<double> all;
  for (const OutputFileJob& output : outputs) all.insert(all.end(), output.isos.begin(), output.isos.end());
  return all;
}

Json json_of(const ConversionJob& job) { return JobJson::encode(job); }

Result<ConversionJob> job_of(const Json& json) {
  ConversionJob job;
  const JobJson::Expected problem = JobJson::decode(json, job);
  if (!problem.empty()) return fail(ErrorKind::usage, fmt::format("a conversion job: expected {}", problem));
  return job;
}

std::string hash_of(const ConversionJob& job) {
  // Not as text, which has no room for paths that are not UTF-8.
  const std::vector<std::uint8_t> bytes = Json::to_cbor(json_of(job));
  const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace isoextract::convert
