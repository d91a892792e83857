// What a batch has done so far, in a file beside its outputs, so that a later run can go on where it was ended.
//
// A text of lines: a header, then a record for each frame that is done, added when its outputs have their names, and a
// line for each that is done anew, which ends its record. Each line is JSON behind the hash of itself, written at once;
// one that a crash has torn is not believed, and ends what is believed. The manifest is locked while its batch
// runs, by a lock that goes with its process.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "base/error.hpp"
#include "batch/frame_record.hpp"
#include "batch/shard.hpp"

namespace isoextract::batch {

struct ManifestHeader {
  std::string program;       // and its version: another one's records are not trusted
  std::string batch;         // hash_of() all frames, of all shards
  std::uint64_t frames = 0;  // of the batch
  Shard shard;
  std::vector<std::string> arguments;  // of the run that began it, for readers
  // As FrameRange reads them; empty in manifests of shards that know nothing of it.
  std::string numbers = {};  // of the batch's frames
  std::string absent = {};   // of frames that were asked for and have no input, where that is an error

  friend bool operator==(const ManifestHeader&, const ManifestHeader&) = default;
};

// This program's, for a batch.
[[nodiscard]] ManifestHeader header_of(const BatchJob& batch, const Shard& shard,
                                       const std::vector<std::string>& arguments);

struct ManifestContent {
  ManifestHeader header;
  std::vector<FrameRecord> records;  // the last of each job, in the order of the file
};

// Fails with ErrorCode::input where there is no such file, or it is no manifest.
[[nodiscard]] Result<ManifestContent> read_manifest(const std::filesystem::path& path);

// The file's name in the folder of the outputs: "isoextract.manifest", with the shard's number where there are several.
[[nodiscard]] std::string manifest_name(const Shard& shard);

// Whether a run keeps its records under such a name: that of the whole batch or of one of its shards.
[[nodiscard]] bool is_manifest_name(std::string_view name);

// The manifests in a folder, of whole batches and of shards, by name. Fails with ErrorCode::input where the folder
// cannot be read.
[[nodiscard]] Result<std::vector<std::filesystem::path>> manifest_paths(const std::filesystem::path& folder);

class Manifest {
 public:
  // Opens or makes the file in `folder` and locks it, and the folder against a run with other shards. Records of the
  // same program stay until their frame is begun anew; in a shard's manifest, which is of one batch, only those of
  // `jobs`, the hashes of the run's. With `resume` the run takes over what the folder's other manifests have of these,
  // so that another number of shards goes on where the first one was ended. Fails with ErrorCode::output where
  // that is not possible, or another run has the lock.
  [[nodiscard]] static Result<Manifest> open(const std::filesystem::path& folder, const ManifestHeader& header,
                                             bool resume, const std::unordered_set<std::string>& jobs);

  Manifest(Manifest&&) noexcept;
  Manifest& operator=(Manifest&&) noexcept;
  ~Manifest();

  [[nodiscard]] const std::filesystem::path& path() const;
  // The record of a job by its hash: of earlier runs, and only where `resume` asks for them. Those that are added are
  // on disk only, so that a run takes no memory for each frame.
  [[nodiscard]] const FrameRecord* find(const std::string& job) const;
  // Before a job's outputs are touched: what was known of them holds no more. Fails with ErrorCode::output.
  [[nodiscard]] Result<void> begin(const std::string& job);
  // Fails with ErrorCode::output.
  [[nodiscard]] Result<void> add(const FrameRecord& record);

 private:
  struct State;
  explicit Manifest(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::batch
