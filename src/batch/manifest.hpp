// The manifest of a batch: a file beside the outputs that lists the finished frames, so that a later run can resume.
//
// A text file: a header line, then one line for each record, added when the frame's outputs are in place. A line
// {"begun_anew": JOB} revokes the earlier record of that job. Each line is a hash followed by the JSON that it covers,
// written at once. A line that a crash has truncated is ignored, and so is everything after it.
//
// The manifest is locked while its batch runs; the lock ends with the process.
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
  std::string program;       // name and version: records of another version are not trusted
  std::string batch;         // hash_of() of the whole batch, not of one shard
  std::uint64_t frames = 0;  // number of frames in the batch
  Shard shard;
  // The command line of the run that wrote the header; runs that resume the same batch keep it. Only for people.
  std::vector<std::string> arguments;
  // FrameRange texts; empty in manifests that older versions wrote.
  std::string numbers = {};  // the numbers of the batch's frames
  std::string absent = {};   // requested frames without input, if missing inputs are an error

  friend bool operator==(const ManifestHeader&, const ManifestHeader&) = default;
};

// Returns the header of this program's manifest for a batch.
[[nodiscard]] ManifestHeader header_of(const BatchJob& batch, const Shard& shard,
                                       const std::vector<std::string>& arguments);

struct ManifestContent {
  ManifestHeader header;
  // The last record of each job that is not revoked, in the order in which the jobs first occur in the file.
  std::vector<FrameRecord> records;
};

// Reads a manifest. Fails with ErrorCode::input if the file does not exist or is no manifest.
[[nodiscard]] Result<ManifestContent> read_manifest(const std::filesystem::path& path);

// Returns the manifest's file name: "isoextract.manifest", with the shard's number and count if there are several.
[[nodiscard]] std::string manifest_name(const Shard& shard);

// Returns whether this is the file name of a manifest, of a whole batch or of a shard.
[[nodiscard]] bool is_manifest_name(std::string_view name);

// Returns the manifests in a folder, of whole batches and of shards, sorted by name. Fails with ErrorCode::input if the
// folder cannot be read.
[[nodiscard]] Result<std::vector<std::filesystem::path>> manifest_paths(const std::filesystem::path& folder);

class Manifest {
 public:
  // Opens or creates the manifest in `folder` and locks it. Also locks the folder: shared for a run of one shard,
  // exclusive for a run without shards.
  //
  // Keeps the records that this version of the program wrote; revoke() removes them one by one. A shard's manifest
  // holds one batch: if the file is of another batch, only the records of `jobs` (the hashes of this run's jobs) stay.
  // With `resume`, takes over the records of `jobs` from other manifests in the folder, so that a run with another
  // number of shards can resume.
  //
  // Fails with ErrorCode::output if the file cannot be read or written, if it is no manifest, or if another run holds
  // the lock.
  [[nodiscard]] static Result<Manifest> open(const std::filesystem::path& folder, const ManifestHeader& header,
                                             bool resume, const std::unordered_set<std::string>& jobs);

  Manifest(Manifest&&) noexcept;
  Manifest& operator=(Manifest&&) noexcept;
  ~Manifest();

  [[nodiscard]] const std::filesystem::path& path() const;
  // Returns the record of a job by its hash, or null. Finds only records of earlier runs, and only with `resume`. To
  // save memory, records that this run adds are on disk only.
  [[nodiscard]] const FrameRecord* find(const std::string& job) const;
  // Revokes the job's earlier record. Call before the job's outputs are overwritten. Fails with ErrorCode::output.
  [[nodiscard]] Result<void> revoke(const std::string& job);
  // Appends a record. Fails with ErrorCode::output.
  [[nodiscard]] Result<void> add(const FrameRecord& record);
  // Removes the manifest of a whole batch if this run created it and no frame was finished. The manifest of a shard
  // stays: merge_shards() reads from it which frames failed.
  void remove_if_unused() const;

 private:
  struct State;
  explicit Manifest(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::batch
