#include "sandbox/detail/system_calls.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isoextract::sandbox::detail {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kArchitecture = 0;
#endif

constexpr std::uint32_t kRefuse = SECCOMP_RET_ERRNO | EPERM;
constexpr std::uint32_t kUnknown = SECCOMP_RET_ERRNO | ENOSYS;  // ENOSYS makes the C library use an older call

constexpr std::uint32_t kSetOwnerEx = 15;  // F_SETOWN_EX
// Numbers that all architectures share.
constexpr int kFchmodat2 = 452;
constexpr int kSetxattrat = 463;
constexpr int kRemovexattrat = 466;

constexpr std::array kForbidden {
  // sockets, and calls that could circumvent the other rules
  __NR_socket, __NR_connect, __NR_bind, __NR_listen, __NR_accept, __NR_accept4, __NR_io_uring_setup, __NR_bpf,
      __NR_perf_event_open, __NR_userfaultfd, __NR_unshare, __NR_setns, __NR_keyctl, __NR_add_key, __NR_request_key,
      // programs and other processes
      __NR_execve, __NR_execveat, __NR_ptrace, __NR_process_vm_readv, __NR_process_vm_writev, __NR_pidfd_open,
      __NR_pidfd_getfd, __NR_pidfd_send_signal, __NR_setrlimit, __NR_kcmp, __NR_tkill, __NR_rt_sigqueueinfo,
      __NR_rt_tgsigqueueinfo,
      // the file system
      __NR_openat2, __NR_open_by_handle_at, __NR_unlinkat, __NR_renameat2, __NR_renameat, __NR_linkat, __NR_symlinkat,
      __NR_mkdirat, __NR_mknodat, __NR_fchmod, __NR_fchmodat, __NR_fchown, __NR_fchownat, __NR_truncate, __NR_ftruncate,
      __NR_fallocate, __NR_utimensat, __NR_setxattr, __NR_lsetxattr, __NR_fsetxattr, __NR_removexattr,
      __NR_lremovexattr, __NR_fremovexattr, __NR_mount, __NR_umount2, __NR_pivot_root, __NR_chroot, __NR_memfd_create,
#if defined(__x86_64__)
      __NR_creat, __NR_unlink, __NR_rename, __NR_link, __NR_symlink, __NR_mkdir, __NR_rmdir, __NR_mknod, __NR_chmod,
      __NR_chown, __NR_lchown, __NR_utime, __NR_utimes, __NR_futimesat, __NR_fork, __NR_vfork,
#endif
      // calls that the headers of older systems do not name
      kFchmodat2, kSetxattrat, kRemovexattrat,
};

sock_filter load(std::size_t offset) { return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)); }

constexpr std::size_t kNumber = offsetof(seccomp_data, nr);
// Returns the offset of an argument's lower 32 bits on a little-endian machine.
constexpr std::size_t lower_half(std::size_t argument) { return offsetof(seccomp_data, args) + 8 * argument; }

class Filter {
 public:
  // System call numbers are only valid for one architecture.
  void check_architecture() {
    rules_.push_back(load(offsetof(seccomp_data, arch)));
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0));
    end(kRefuse);
    rules_.push_back(load(kNumber));
#if defined(__x86_64__)
    constexpr std::uint32_t kX32 = 0x40000000;
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, kX32, 0, 1));
    end(kRefuse);
#endif
  }

  void answer(long call, std::uint32_t with) {
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1));
    end(with);
  }

  // Refuses a call if its argument has any of `bits`; with `or_none`, instead, if it has none of them.
  void refuse_bits(long call, std::size_t argument, std::uint32_t bits, bool or_none = false) {
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4));
    rules_.push_back(load(lower_half(argument)));
    const std::uint8_t skipped_if_set = or_none ? 1 : 0;
    const std::uint8_t skipped_if_not = or_none ? 0 : 1;
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, skipped_if_set, skipped_if_not));
    end(kRefuse);
    end(SECCOMP_RET_ALLOW);
  }

  // Refuses a call if its argument is `value`.
  void refuse_value(long call, std::size_t argument, std::uint32_t value) {
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 3));
    rules_.push_back(load(lower_half(argument)));
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 0, 1));
    end(kRefuse);
    rules_.push_back(load(kNumber));
  }

  // Refuses a call unless its argument is `value`.
  void refuse_others(long call, std::size_t argument, std::uint32_t value) {
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 4));
    rules_.push_back(load(lower_half(argument)));
    rules_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, value, 1, 0));
    end(kRefuse);
    end(SECCOMP_RET_ALLOW);
  }

  void end(std::uint32_t with) { rules_.push_back(BPF_STMT(BPF_RET | BPF_K, with)); }

  bool install() {
    const sock_fprog program{static_cast<unsigned short>(rules_.size()), rules_.data()};
    return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
  }

 private:
  std::vector<sock_filter> rules_;
};

}  // namespace

bool restrict_system_calls() {
  if (kArchitecture == 0) return false;
  const auto self = static_cast<std::uint32_t>(::getpid());
  constexpr std::uint32_t kWrites = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND | (O_TMPFILE & ~O_DIRECTORY);
  Filter filter;
  filter.check_architecture();
  for (const long call : kForbidden) filter.answer(call, kRefuse);
  filter.answer(__NR_clone3, kUnknown);  // its flags are in memory, which a filter cannot read
  filter.refuse_bits(__NR_clone, 0, CLONE_THREAD, true);
  filter.refuse_bits(__NR_openat, 2, kWrites);
#if defined(__x86_64__)
  filter.refuse_bits(__NR_open, 1, kWrites);
#endif
  filter.refuse_bits(__NR_prlimit64, 2, ~std::uint32_t{0});  // refuses new limits; the C library uses this call to read
                                                             // old ones
  // A worker could make another process the owner of a descriptor, which then gets SIGIO.
  filter.refuse_value(__NR_fcntl, 1, F_SETOWN);
  filter.refuse_value(__NR_fcntl, 1, kSetOwnerEx);
  // abort() sends a signal to its own process.
  filter.refuse_others(__NR_kill, 0, self);
  filter.refuse_others(__NR_tgkill, 0, self);
  filter.end(SECCOMP_RET_ALLOW);
  return filter.install();
}

}  // namespace isoextract::sandbox::detail
