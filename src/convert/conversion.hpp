// Runs one conversion: takes a job, returns an outcome. Prints nothing and throws nothing. Keeps no state between runs
// except in the BackendCache given to it, so conversions can run side by side, each with its own Context.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "base/note.hpp"
#include "base/ranks.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/mesh_collector.hpp"
#include "convert/outcome.hpp"
#include "files/input_file_set.hpp"

namespace isoextract::convert {

// Extra results and settings of a run.
struct ConversionOptions {
  // Measures each written mesh (StageName::mesh_facts): components, open edges, sizes. Takes longer than extraction.
  bool mesh_facts = false;
  // Returns notes about the field to extract (after filters, blur and resampling), worded by the caller. Null: no such
  // notes. Every converting thread may call it.
  std::function<Notes(const field::ScalarField&)> field_notes = nullptr;
  // Caller's advice how to keep the volumes of surface nets; ends the note that relaxing changed them. Empty: no note.
  std::string volume_hint = {};
  // Hashes mesh files while writing them (mesh_io::WrittenFile).
  bool hash_files = false;
  // Files that must not be overwritten, including the job's inputs. Null: only the job's inputs.
  const files::InputFileSet* read = nullptr;
  // Ranks that share the conversion, each a part of the samples. Null: this process does all of it.
  Ranks* ranks = nullptr;
};

// Runs the job's stages: opens a backend, reads, and for each file extracts, verifies, simplifies, measures and writes.
// Writes each surface as soon as the file format allows, and leaves no partial file behind. Outcome::error says what
// failed. Calls `events` on this thread. With `kept`, uses its backends; the written files do not depend on it.
//
// With ConversionOptions::ranks, all ranks run the job. If they cannot share this conversion, rank 0 runs it, and the
// others fail with ErrorCode::cancelled, before they write.
//
// With a `collector`, writes no mesh file and no picture, and lists none in Outcome::files: the collector gets the
// meshes of each output. Everything else is as if the job's files were written. Field files and particle files are
// written and listed even so.
[[nodiscard]] Outcome run(const ConversionJob& job, const Context& context, Events& events,
                          const ConversionOptions& extras = {}, BackendCache* kept = nullptr,
                          MeshCollector* collector = nullptr);

}  // namespace isoextract::convert
