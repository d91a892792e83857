// The record of a finished frame: the state of its files, by which a later run finds changes, and its figures for the
// table of all frames.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "batch/batch_job.hpp"
#include "convert/iso_choice.hpp"
#include "convert/json_type.hpp"
#include "convert/outcome.hpp"
#include "files/content_hash.hpp"
#include "particle_io/particle_format.hpp"

namespace isoextract::batch {

struct SurfaceFigures {
  convert::SurfaceId id;
  std::string asked;  // "p99" or "label 5"; empty if the iso value was given as a number
  std::uint64_t triangles = 0;
  // Set if mesh statistics were requested (ConversionOptions::mesh_facts).
  std::optional<std::uint64_t> vertices;
  std::optional<std::uint64_t> components;
  std::optional<bool> closed;
  std::optional<double> area;
  std::optional<double> volume;  // of a closed mesh
  // Set if the surface was written to files of its frame. If several outputs contain it, only the first one counts.
  std::string output;                  // the first file of that output that contains the surface
  std::optional<std::uint64_t> bytes;  // size of all its files that contain the surface, with what else they contain
  // Set if the error was measured. In voxels; error: distances from the mesh to the isosurface of the data, coverage:
  // distances from that isosurface to the mesh.
  std::optional<double> error_rms;
  std::optional<double> error_max;
  std::optional<double> coverage_rms;
  std::optional<double> coverage_max;
  std::string grid = {};  // the surface's grid, if the conversion has several
  // One entry for each file if the surface's bodies are in several files, else empty. Each entry has the error figures
  // of the whole surface.
  std::vector<SurfaceFigures> files = {};

  friend bool operator==(const SurfaceFigures&, const SurfaceFigures&) = default;
};

struct FrameFigures {
  std::vector<SurfaceFigures> surfaces;  // extracted, or the meshes of a mesh file
  std::uint64_t bytes = 0;               // size of all written files
  double wall_seconds = 0;
  std::uint64_t memory = 0;                    // peak of the reserved memory, in bytes
  particle_io::FrameTime time;                 // of a frame of particles
  std::vector<std::string> lacked_attributes;  // optional attributes that the input lacks
  std::string unit = {};                       // of lengths in the meshes: "mm"; empty if unknown
  double front = 0;  // camera azimuth, in degrees, that shows a patient's front; 0 for other inputs (Outcome::front)

  friend bool operator==(const FrameFigures&, const FrameFigures&) = default;
};

[[nodiscard]] FrameFigures figures_of(const convert::Outcome& outcome);

// Returns one row for each surface, or for each file of a surface whose bodies have several files.
[[nodiscard]] std::vector<const SurfaceFigures*> rows_of(const FrameFigures& figures);

struct FileRecord {
  std::string path;
  files::ContentState state;
  // The bytes that state.hash covers; empty: the whole file. In a file of several frames these are the frame's bytes.
  std::vector<files::ByteRange> ranges = {};

  friend bool operator==(const FileRecord&, const FileRecord&) = default;
};

struct FrameRecord {
  std::int64_t frame = 0;
  std::string job;                  // convert::hash_of() of the frame's job
  std::vector<FileRecord> inputs;   // including data files that headers (.nhdr, .hdr) name; none for a demo field
  std::vector<FileRecord> outputs;  // none if the surface was empty and skipped
  FrameFigures figures;

  friend bool operator==(const FrameRecord&, const FrameRecord&) = default;
};

// Returns the state of the frame's inputs now. Call before converting the frame, so that a later run notices a change
// during the conversion. Fails as convert::list_source_parts() and files::hash_part() do.
[[nodiscard]] Result<std::vector<FileRecord>> input_states(const FrameJob& frame, const Context& context);

// Makes the record of a frame that was just finished. Reads again only outputs whose hash the outcome lacks or whose
// size has changed; fails with ErrorCode::input if it cannot read one.
[[nodiscard]] Result<FrameRecord> record_of(const FrameJob& frame, std::vector<FileRecord> inputs,
                                            const convert::Outcome& outcome, const Context& context);

// Returns a message about an input of the frame that exists now but not in the record, such as the file of an optional
// attribute: "h_03.npy is new". Also returns a message if the inputs cannot be listed, or if the frame has moved within
// its file. Otherwise returns an empty text.
[[nodiscard]] std::string added_input_message(const FrameRecord& record, const FrameJob& frame);

// Returns whether the record lists the inputs; true for a demo field, which has none. False if they could not be hashed
// before the conversion.
[[nodiscard]] bool knows_inputs(const FrameRecord& record, const FrameJob& frame);

// Returns a message about the first file of the record that has changed or cannot be read: "in.vdb has changed". Empty
// if there is none. Compares the recorded bytes of all files, and the modification time of inputs recorded as whole
// files.
[[nodiscard]] std::string changed_file_message(const FrameRecord& record);

// Returns why a recorded frame must be converted again: "in.vdb has changed". Empty if the job is unchanged and
// changed_file_message() and added_input_message() are empty. A record without inputs counts as changed, except for
// demo fields.
[[nodiscard]] std::string reason_to_reconvert(const FrameRecord& record, const FrameJob& frame);

[[nodiscard]] convert::Json json_of(const FrameRecord& record);
// Parses a record. Returns nullopt if the JSON is not a frame record.
[[nodiscard]] std::optional<FrameRecord> record_of(const convert::Json& json);

}  // namespace isoextract::batch
