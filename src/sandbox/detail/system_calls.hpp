// Restricts system calls with the kernel's seccomp filter.
#pragma once

namespace isoextract::sandbox::detail {

// Makes system calls of this process fail with EPERM from now on that open a socket, start a program or a process, open
// a file for writing, change the file system, or access another process. Returns false if the kernel or processor has
// no such filter or does not permit it.
bool restrict_system_calls();

}  // namespace isoextract::sandbox::detail
