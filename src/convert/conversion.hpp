// One conversion: a job in, an outcome out. Prints nothing, throws nothing, and keeps nothing between two runs but what
// it is given to keep, so that conversions can run side by side, each with a Context of its own.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "base/context.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/mesh_collector.hpp"
#include "convert/outcome.hpp"
#include "files/read_files.hpp"

namespace isoextract::convert {

// What is found out only for who asks, because it takes time.
struct OutcomeExtras {
  bool mesh_facts =
      false;  // Outcome::meshes: components, open edges, sizes; longer than the extraction, see reports.md
  // Returns a note about the field that is read, in words that only the caller has; null: there is none. Every thread
  // that converts may call it.
  std::function<std::optional<std::string>(const field::ScalarField&)> note_of_field = nullptr;
  // How the volumes of surface nets are kept, in words that only the caller has: ends the note that relaxing changed
  // them; empty: there is none.
  std::string how_to_keep_volumes = {};
  // The files of meshes are hashed while they are written (mesh_io::WrittenFile).
  bool hash_files = false;
  // What is not to be overwritten, the job's own inputs among it; null: those alone.
  const files::ReadFiles* read = nullptr;
};

// Runs the job's stages: open a backend, read, and for each file extract, verify, simplify, measure, write. A surface
// is written as soon as its file's format allows; nothing is left behind of a file that could not be written whole.
// What went wrong is Outcome::error. `events` are told on this thread. With `kept` the backends are those that it keeps
// for the runs that share it; what is written does not depend on it.
//
// With a `collector` no file is written: it gets the meshes of each output instead, and Outcome::files stays empty. All
// else is as it would be for the files that the job names.
[[nodiscard]] Outcome run(const ConversionJob& job, const Context& context, Events& events,
                          const OutcomeExtras& extras = {}, KeptBackends* kept = nullptr,
                          MeshCollector* collector = nullptr);

}  // namespace isoextract::convert
