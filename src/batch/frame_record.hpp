// What is kept of a frame that is done: enough to tell later that its files are still those that it made, and what the
// table over all frames shows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_job.hpp"
#include "convert/json_type.hpp"
#include "convert/outcome.hpp"
#include "files/content_hash.hpp"

namespace isoextract::batch {

struct SurfaceFigures {
  double iso = 0;
  std::string asked;  // "p99"; empty where that was the number
  std::uint64_t triangles = 0;
  // Where the facts of meshes were asked for.
  std::optional<std::uint64_t> vertices;
  std::optional<std::uint64_t> components;
  std::optional<bool> closed;
  std::optional<double> area;
  std::optional<double> volume;  // of a closed mesh
  // Where the surface went to files of its frame.
  std::string output;                  // the first of them
  std::optional<std::uint64_t> bytes;  // of all of them, with the other surfaces in them
  // Where the error was measured, in voxels: from the mesh to the surface of the data, and the other way.
  std::optional<double> error_rms;
  std::optional<double> error_max;
  std::optional<double> coverage_rms;
  std::optional<double> coverage_max;
  std::string grid = {};  // whose surface it is, where the conversion has several
  // Where its pieces went to several files: the figures of each file, whose errors are those of the whole surface.
  std::vector<SurfaceFigures> files = {};

  friend bool operator==(const SurfaceFigures&, const SurfaceFigures&) = default;
};

struct FrameFigures {
  std::vector<SurfaceFigures> surfaces;  // in the job's order; those that were extracted
  std::uint64_t bytes = 0;               // that were written
  double wall_seconds = 0;
  std::uint64_t memory = 0;                    // the most that was reserved
  std::string time_step;                       // the number that the input gives the frame; empty where it has none
  std::vector<std::string> lacked_attributes;  // optional ones that the input does not have
  std::string unit = {};                       // of lengths in the meshes: "mm"; empty where nothing says it

  friend bool operator==(const FrameFigures&, const FrameFigures&) = default;
};

[[nodiscard]] FrameFigures figures_of(const convert::Outcome& outcome);

// What tables have a row of: the surfaces, and instead of one whose pieces went to several files each of these.
[[nodiscard]] std::vector<const SurfaceFigures*> rows_of(const FrameFigures& figures);

struct FileRecord {
  std::string path;
  files::FileState state;

  friend bool operator==(const FileRecord&, const FileRecord&) = default;
};

struct FrameRecord {
  std::int64_t frame = 0;
  std::string job;                  // convert::hash_of()
  std::vector<FileRecord> inputs;   // with those that hold samples apart; none of a demo field
  std::vector<FileRecord> outputs;  // none where the surface was empty and skipped
  FrameFigures figures;

  friend bool operator==(const FrameRecord&, const FrameRecord&) = default;
};

// The inputs as they are now: to be asked before the frame is converted, so that one that changes meanwhile is not
// taken for what was read. Fails where one cannot be read.
[[nodiscard]] Result<std::vector<FileRecord>> input_states(const FrameJob& frame, const Context& context);

// Of a frame that was just done. Files whose hash the outcome has are not read again; fails where others cannot be.
[[nodiscard]] Result<FrameRecord> record_of(const FrameJob& frame, std::vector<FileRecord> inputs,
                                            const convert::Outcome& outcome, const Context& context);

// An input of the frame that is there now and was not when the record was made, such as the file of an optional
// attribute: "h_03.npy was not there"; empty where there is none.
[[nodiscard]] std::string what_came(const FrameRecord& record, const FrameJob& frame);

// False where the inputs could not be read when the frame was begun, and could when it was converted: nobody knows what
// it was made of.
[[nodiscard]] bool knows_inputs(const FrameRecord& record, const FrameJob& frame);

// The first of the record's files that is not what it was, byte by byte: "in.vdb has changed"; empty where all are.
[[nodiscard]] std::string what_changed(const FrameRecord& record);

// Why the frame has to be done again although there is a record of its job: "in.vdb has changed"; empty where all
// inputs and outputs are what they were, byte by byte, and no input has come. A file's record without inputs is not
// believed.
[[nodiscard]] std::string why_again(const FrameRecord& record, const FrameJob& frame);

[[nodiscard]] convert::Json json_of(const FrameRecord& record);
// The other way; nothing where it is none.
[[nodiscard]] std::optional<FrameRecord> record_of(const convert::Json& json);

}  // namespace isoextract::batch
