// What is said between this program and a worker that reads a file with a plug-in (sandbox/worker.hpp). A message
// begins with one of these; what comes then stands beside it. Everything that a worker says is checked: it may be in
// the hands of the file that it reads.
#pragma once

#include <cstdint>

#include "sandbox/message.hpp"

namespace isoextract::plugin_host {

enum class Said : std::uint64_t {
  // The program, of a volume:
  list_volume,  // path, first bytes of the file
  open_grid,    // number of the grid, bytes of the full box; with memory for it unless that is 0
  // The program, of particles:
  open_particles,  // path, 1 and the name of a grid or 0, frame
  positions,
  quantity,  // its number
  // The program, as an answer:
  granted,  // with memory where that was asked for
  refused,
  // The worker:
  failed,       // why
  not_of_it,    // the file is none of the format
  listed,       // count; of each grid what isoextract_volume_grid has
  reserve,      // bytes
  release,      // bytes
  allocate,     // bytes
  box_opened,   // note, whether there are samples, bytes
  grid_opened,  // note, whether there are samples, what isoextract_sparse_samples has; blocks and tiles as SharedPlace
  particles_opened,  // what isoextract_particle_file has; of each quantity what isoextract_particle_quantity has
  filled,            // bytes; then that many, numbers of all particles
};

// A message that begins so.
[[nodiscard]] inline sandbox::MessageWriter say(Said what) {
  sandbox::MessageWriter message;
  message.number(static_cast<std::uint64_t>(what));
  return message;
}

// A place in one of the memories that the worker has asked for, by their number.
struct SharedPlace {
  std::uint64_t memory = 0;
  std::uint64_t offset = 0;
};

// A block as it lies in shared memory.
struct SharedBlock {
  std::int32_t origin[3];  // NOLINT(modernize-avoid-c-arrays): as isoextract_sparse_block has it
  std::uint32_t memory;    // of its values
  std::uint64_t offset;
};

}  // namespace isoextract::plugin_host
