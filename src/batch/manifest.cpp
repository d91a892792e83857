#include "batch/manifest.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "base/version.hpp"
#include "batch/frame_range.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"
#include "files/output_file.hpp"
#include "files/text_file.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;
using convert::Json;

constexpr int kManifestVersion = 1;
constexpr std::size_t kHashDigits = 32;
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 32;
static_assert(kMostBytes / kMaxFrames >= 4000, "a frame takes about a thousand bytes");
constexpr const char* kRevocationKey = "begun_anew";

tl::unexpected<Error> output_error(const fs::path& path, std::string_view action, int code) {
  return fail(ErrorCode::output,
              fmt::format("{}: cannot {}: {}", path.string(), action, std::generic_category().message(code)));
}

// Arguments may hold bytes that are not UTF-8; each such byte becomes U+FFFD.
std::string line_of(const Json& json) {
  const std::string text = convert::json_line(json);
  return fmt::format("{} {}\n", files::content_hash(text), text);
}

// Removes the next line and returns its JSON. Returns nullopt if the line is truncated or its hash does not match.
std::optional<Json> take_record_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos || end <= kHashDigits || text[kHashDigits] != ' ') return std::nullopt;
  const std::string_view json = text.substr(kHashDigits + 1, end - kHashDigits - 1);
  if (files::content_hash(json) != text.substr(0, kHashDigits)) return std::nullopt;
  text.remove_prefix(end + 1);
  return Json::parse(json, nullptr, false);
}

Json json_of(const ManifestHeader& header) {
  return {{"schema", word_of(convert::JsonDocument::manifest)},
          {"isoextract_manifest", kManifestVersion},
          {"program", header.program},
          {"batch", header.batch},
          {"frames", header.frames},
          {"shard", {header.shard.number, header.shard.count}},
          {"arguments", header.arguments},
          {"numbers", header.numbers},
          {"absent", header.absent}};
}

std::optional<ManifestHeader> header_of(const Json& json) {
  try {
    if (json.at("isoextract_manifest") != kManifestVersion) return std::nullopt;
    return ManifestHeader{json.at("program").get<std::string>(),
                          json.at("batch").get<std::string>(),
                          json.at("frames").get<std::uint64_t>(),
                          {json.at("shard").at(0).get<int>(), json.at("shard").at(1).get<int>()},
                          json.at("arguments").get<std::vector<std::string>>(),
                          json.value("numbers", std::string()),
                          json.value("absent", std::string())};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

Json revocation_json(const std::string& job) { return {{kRevocationKey, job}}; }

std::optional<std::string> revoked_job(const Json& json) {
  const auto job = json.is_object() ? json.find(kRevocationKey) : json.end();
  if (!json.is_object() || job == json.end() || !job->is_string()) return std::nullopt;
  return job->get<std::string>();
}

std::optional<ManifestContent> content_of(std::string_view text) {
  const auto first = take_record_line(text);
  auto header = first ? header_of(*first) : std::nullopt;
  if (!header) return std::nullopt;
  ManifestContent content{std::move(*header), {}};
  std::unordered_map<std::string, std::size_t> place_of;
  std::vector<std::optional<FrameRecord>> records;
  while (const auto line = take_record_line(text)) {
    auto record = record_of(*line);
    const auto begun = record ? record->job : revoked_job(*line);
    if (!begun) break;
    const auto [place, is_new] = place_of.try_emplace(*begun, records.size());
    if (is_new) records.emplace_back();
    records[place->second] = std::move(record);
  }
  for (auto& record : records) {
    if (record) content.records.push_back(std::move(*record));
  }
  return content;
}

// Returns whether the text can be a truncated manifest: it begins with the hash of a header, or a part of the hash.
bool may_be_truncated(std::string_view text) {
  return text.substr(0, kHashDigits).find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// Adds records of these jobs from all other manifests in the folder that the same program version wrote.
void add_other_manifests(const fs::path& folder, const fs::path& own, const ManifestHeader& header,
                         const std::unordered_set<std::string>& jobs, std::vector<FrameRecord>& records) {
  std::unordered_set<std::string> known;
  for (const FrameRecord& record : records) known.insert(record.job);
  const auto paths = manifest_paths(folder);
  if (!paths) return;
  for (const fs::path& path : *paths) {
    if (path.filename() == own.filename()) continue;
    auto other = read_manifest(path);  // a file that is no manifest has no records
    if (!other || other->header.program != header.program) continue;
    for (FrameRecord& record : other->records) {
      if (jobs.contains(record.job) && known.insert(record.job).second) records.push_back(std::move(record));
    }
  }
}

Result<std::string> text_of_file(const fs::path& path) {
  return files::read_text_file(path, "the manifest of a batch", kMostBytes,
                               Context());  // not counted as bytes read, because a manifest is no input
}

}  // namespace

ManifestHeader header_of(const BatchJob& batch, const Shard& shard, const std::vector<std::string>& arguments) {
  std::vector<std::int64_t> numbers;
  for (const FrameJob& frame : batch.frames) numbers.push_back(frame.number);
  return {std::string(generator()), hash_of(batch), batch.frames.size(), shard, arguments, text_of(runs_of(numbers))};
}

std::string manifest_name(const Shard& shard) {
  return shard.is_all() ? "isoextract.manifest"
                        : fmt::format("isoextract.{}-of-{}.manifest", shard.number, shard.count);
}

bool is_manifest_name(std::string_view name) {
  constexpr std::string_view kStart = "isoextract.";
  constexpr std::string_view kEnd = ".manifest";
  return name == manifest_name({}) ||
         (name.size() > kStart.size() + kEnd.size() && name.starts_with(kStart) && name.ends_with(kEnd));
}

Result<std::vector<fs::path>> manifest_paths(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (is_manifest_name(entry->path().filename().string())) paths.push_back(entry->path());
  }
  if (error) {
    return fail(ErrorCode::input, fmt::format("{}: cannot read the folder: {}", folder.string(), error.message()));
  }
  std::ranges::sort(paths);
  return paths;
}

Result<ManifestContent> read_manifest(const fs::path& path) {
  const auto text = TRY(text_of_file(path));
  auto content = content_of(text);
  if (!content)
    return fail(ErrorCode::input, fmt::format("{}: this file is not the manifest of a batch", path.string()));
  return std::move(*content);
}

struct Manifest::State {
  fs::path path;
  int file = -1;
  int before = -1;  // the replaced file; stays open, so that a run that opened it cannot lock it
  int folder = -1;  // also locked
  bool resume = false;
  bool is_used = false;                                  // has records, existed before, or is of a shard
  std::unordered_map<std::string, FrameRecord> records;  // of earlier runs; without `resume` only their jobs

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    for (const int handle : {file, before, folder}) {
      if (handle >= 0) ::close(handle);
    }
  }

  void keep(std::vector<FrameRecord> old) {
    for (FrameRecord& record : old) {
      std::string job = record.job;
      records.emplace(std::move(job), resume ? std::move(record) : FrameRecord());
    }
  }

  [[nodiscard]] Result<void> append(const std::string& line) const {
    std::string_view rest = line;
    while (!rest.empty()) {
      const ssize_t written = ::write(file, rest.data(), rest.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return output_error(path, "write", errno);
      rest.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
  }
};

Manifest::Manifest(std::unique_ptr<State> state) : state_(std::move(state)) {}
Manifest::Manifest(Manifest&&) noexcept = default;
Manifest& Manifest::operator=(Manifest&&) noexcept = default;
Manifest::~Manifest() = default;

Result<Manifest> Manifest::open(const fs::path& folder, const ManifestHeader& header, bool resume,
                                const std::unordered_set<std::string>& jobs) {
  auto state = std::make_unique<State>();
  const auto in_use = [&] {
    return fail(ErrorCode::output,
                fmt::format("{}: another run writes into this folder", folder.empty() ? "." : folder.string()),
                "wait until that run ends, or choose another folder");
  };
  // Shards share the folder, other runs lock it exclusively. Some file systems cannot lock folders; then only files are
  // locked.
  state->folder = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (state->folder < 0) return output_error(folder, "open the folder", errno);
  const int kind = header.shard.is_all() ? LOCK_EX : LOCK_SH;
  if (::flock(state->folder, kind | LOCK_NB) != 0 && errno == EWOULDBLOCK) return in_use();

  state->path = folder / manifest_name(header.shard);
  constexpr mode_t kNewFile = 0666;  // minus the umask
  state->file = ::open(state->path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, kNewFile);
  if (state->file < 0) return output_error(state->path, "open it for writing", errno);
  if (::flock(state->file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return in_use();

  struct stat status {};
  if (::fstat(state->file, &status) != 0) return output_error(state->path, "read it", errno);
  const auto text = status.st_size == 0 ? Result<std::string>("") : text_of_file(state->path);
  if (!text) return fail(ErrorCode::output, text.error().message, "choose another folder, or move the file away");
  auto old = content_of(*text);
  if (!old && !may_be_truncated(*text)) {
    return fail(ErrorCode::output,
                fmt::format("{}: this file is not the manifest of a batch, and the run does not overwrite the file",
                            state->path.string()),
                "choose another folder, or move the file away");
  }
  state->resume = resume;
  const bool trusted = old && old->header.program == header.program && old->header.shard == header.shard;
  std::vector<FrameRecord> kept;
  if (trusted) {
    std::ranges::copy_if(old->records, std::back_inserter(kept), [&](const FrameRecord& record) {
      return header.shard.is_all() || old->header.batch == header.batch || jobs.contains(record.job);
    });
  }
  if (resume) add_other_manifests(folder, state->path, header, jobs, kept);
  // Records of this batch go last, so that merge_shards() can tell them from records of other batches.
  std::stable_partition(kept.begin(), kept.end(),
                        [&](const FrameRecord& record) { return !jobs.contains(record.job); });
  const bool goes_on = trusted && resume && old->header.batch == header.batch;
  ManifestHeader own = header;
  if (goes_on) own.arguments = old->header.arguments;
  std::string content = line_of(json_of(own));
  for (const FrameRecord& record : kept) content += line_of(batch::json_of(record));
  if (content != *text) {
    // Replaces the file atomically: a killed run leaves the old or the new content.
    if (auto written = files::write_file(state->path, content); !written) {
      if (text->empty()) ::unlink(state->path.c_str());  // the empty file created above for the lock
      return tl::unexpected(written.error());
    }
    state->before = std::exchange(state->file, ::open(state->path.c_str(), O_RDWR | O_APPEND | O_CLOEXEC));
    if (state->file < 0) return output_error(state->path, "open it for writing", errno);
    if (::flock(state->file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return in_use();
  }
  state->is_used = !text->empty() || !kept.empty() || !header.shard.is_all();
  state->keep(std::move(kept));
  return Manifest(std::move(state));
}

const fs::path& Manifest::path() const { return state_->path; }

const FrameRecord* Manifest::find(const std::string& job) const {
  const auto place = state_->records.find(job);
  return !state_->resume || place == state_->records.end() ? nullptr : &place->second;
}

Result<void> Manifest::revoke(const std::string& job) {
  return state_->records.erase(job) == 0 ? Result<void>() : state_->append(line_of(revocation_json(job)));
}

Result<void> Manifest::add(const FrameRecord& record) {
  state_->is_used = true;
  return state_->append(line_of(json_of(record)));
}

void Manifest::remove_if_unused() const {
  if (!state_->is_used) ::unlink(state_->path.c_str());
}

}  // namespace isoextract::batch
