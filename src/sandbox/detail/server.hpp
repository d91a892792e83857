// The server process of a library: loads it once and forks a worker for each file. A file can only damage its worker,
// and no file pays for loading the library again.
#pragma once

#include <cstdint>

#include "sandbox/program.hpp"

namespace isoextract::sandbox::detail {

inline constexpr int kControlSocket = 3;

// For each worker, three descriptors arrive through the control socket: the worker's message socket, its status socket,
// and the pipe for its output. When the worker has ended, the server sends this through the status socket:
struct WorkerStatus {
  std::int32_t wait_status = 0;         // in the form of waitpid; -1 if the worker could not be started
  std::int32_t memory_was_refused = 0;  // nonzero if operator new failed in the worker
};
// The worker is ended by any byte that the parent sends through the status socket, and by the end of the parent.

// Call before loading libraries: closes all descriptors above the control socket, and ignores the signals that a
// terminal or batch system sends to the parent's process group. WorkerPool has opened descriptors 0 to 2 on /dev/null.
void isolate_server();

// Sends the greeting and, if the child can work, serves until the parent closes the control socket. Then ends the
// process with code 0: it never returns.
[[nodiscard]] int serve(const ChildWork& work);

}  // namespace isoextract::sandbox::detail
