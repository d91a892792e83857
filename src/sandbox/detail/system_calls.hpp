// Restricts system calls with the kernel's seccomp filter.
#pragma once

namespace isoextract::sandbox::detail {

// Refuses, from now on, system calls of this process that open a socket, start a program or a process, open a file for
// writing, change the file system or resource limits, or access another process. They fail with EPERM; clone3 fails
// with ENOSYS, so that the C library starts threads with clone. Returns false if the kernel or processor has no such
// filter or does not permit it.
bool restrict_system_calls();

}  // namespace isoextract::sandbox::detail
