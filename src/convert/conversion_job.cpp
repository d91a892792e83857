#include "convert/conversion_job.hpp"

#include <cstdint>

#include <fmt/format.h>

#include "convert/detail/job_json.hpp"
#include "files/content_hash.hpp"

namespace isoextract::convert {

std::vector<IsoChoice> ConversionJob::isos() const {
  std::vector<IsoChoice> all;
  for (const OutputFileJob& output : outputs) all.insert(all.end(), output.isos.begin(), output.isos.end());
  return all;
}

Json json_of(const ConversionJob& job) { return JobJson::encode(job); }

Result<ConversionJob> job_of(const Json& json) {
  ConversionJob job;
  const JobJson::Expected problem = JobJson::decode(json, job);
  if (!problem.empty()) return fail(ErrorCode::usage, fmt::format("a conversion job: expected {}", problem));
  return job;
}

std::string hash_of(const ConversionJob& job) {
  // Not as text, which has no room for paths that are not UTF-8.
  const std::vector<std::uint8_t> bytes = Json::to_cbor(json_of(job));
  return files::content_hash({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace isoextract::convert
