// The protocol between this program and a worker that reads a file with a plug-in (sandbox/worker.hpp). A message
// starts with one of these values, followed by the fields in its comment. The program validates every message of a
// worker, as the file it reads may have taken control of it.
#pragma once

#include <cstdint>

#include "sandbox/message.hpp"

namespace isoextract::plugin_host {

enum class MessageKind : std::uint64_t {
  // From the program, for volumes:
  list_volume,  // path, 1 for a file or 0, first bytes of the file; number of files, path of each; volume, level,
                // spacing, resamples
  open_grid,  // members of isoextract_volume_selection but the box, bytes of the full box; shared memory comes with the
              // message unless these bytes are 0
  // From the program, for particles:
  open_particles,  // path, 1 if a grid is selected or 0, name of the grid or "", frame
  positions,
  quantity,  // index
  // From the program, in reply:
  granted,  // with shared memory if requested
  refused,
  // From the worker:
  failed,            // reason, isoextract_read_failure
  wrong_format,      // the file does not have the plug-in's format
  listed,            // 1 if the list names a format or 0, and the format; creator, note; number of grids, for each the
                     // members of isoextract_volume_grid; number of files, path of each
  reserve,           // bytes
  release,           // bytes
  allocate,          // bytes
  box_opened,        // note, parts_read, parts, filled
  grid_opened,       // note, parts_read, parts, whether there are samples, members of isoextract_sparse_samples; blocks
                     // and tiles as SharedPlace
  particles_opened,  // members of isoextract_particle_file, but instead of its list: 0 if that is null, else 1, and its
                     // length; for each quantity the members of isoextract_particle_quantity
  filled,            // bytes; then that many bytes, the numbers of all particles
};

// Returns a message that starts with this value.
[[nodiscard]] inline sandbox::MessageWriter say(MessageKind what) {
  sandbox::MessageWriter message;
  message.number(static_cast<std::uint64_t>(what));
  return message;
}

// A location in one of the shared memories that the worker requested; `memory` is its index.
struct SharedPlace {
  std::uint64_t memory = 0;
  std::uint64_t offset = 0;
};

// The layout of a block in shared memory.
struct SharedBlock {
  std::int32_t origin[3];  // NOLINT(modernize-avoid-c-arrays): as isoextract_sparse_block has it
  std::uint32_t memory;    // index of the shared memory with its values
  std::uint64_t offset;
};

}  // namespace isoextract::plugin_host
