// The process that is started once for a library, loads it, and forks a worker for each file: what a file does to a
// worker goes with the worker, and no file pays for loading the library again.
#pragma once

#include <cstdint>

#include "sandbox/program.hpp"

namespace isoextract::sandbox::detail {

inline constexpr int kControlSocket = 3;

// Three descriptors come through the control socket for each worker: its socket, the one of its status, and the pipe
// for what it prints. On the one of the status this comes when the worker has ended:
struct WorkerStatus {
  std::int32_t wait_status = 0;    // as waitpid has it; -1 where the worker could not be started
  std::int32_t lacked_memory = 0;  // not 0 where it was refused memory
};
// Any byte that comes from the parent there ends the worker, as does the end of the parent.

// Before libraries are loaded: nothing is open but the control socket, nothing can be printed, and signals for the
// parent's group end nothing here.
void prepare_server();

// Until the parent closes the control socket. Gives the exit code.
[[nodiscard]] int serve(const ChildWork& work);

}  // namespace isoextract::sandbox::detail
