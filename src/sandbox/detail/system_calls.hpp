// The kernel's seccomp: which system calls a process may still make.
#pragma once

namespace isoextract::sandbox::detail {

// From now on, system calls of this process fail with EPERM that would open a socket, start a program or a process,
// open a file for writing, change the file system, or reach into another process. False where this kernel or processor
// has no such filter, or the process may not set one.
bool forbid_system_calls();

}  // namespace isoextract::sandbox::detail
