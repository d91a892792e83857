// The options of the group "Run" that several commands have.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cli/backends.hpp"
#include "cli/option.hpp"
#include "cli/values.hpp"
#include "gl/gpu_device.hpp"

namespace isoextract::cli {

inline constexpr std::string_view kHelpNames = "-h,--help";

// The last options of every command.
struct RunFlags : OptionSet {
  // What a command has of them; each has those before it, too.
  enum class Taken { help, quiet, verbosity, all };

  explicit RunFlags(OptionSet& command, Taken taken = Taken::all);

 private:
  Taken taken_;
  Place from(Taken least) { return taken_ >= least ? Place(*this) : Place(); }

 public:
  Value<int> threads{from(Taken::all), "--threads", "N", parse_thread_count,
                     "Threads to use (default: all). The output does not depend on it. With 1 no other is started."};
  Flag quiet{from(Taken::quiet), "-q,--quiet", "Say nothing but errors and, on stdout, results."};
  Flag verbose{from(Taken::verbosity), "-v,--verbose", "Say also what each stage took, and the peak of memory."};
  Flag help{*this, kHelpNames, "Show the options of this command and exit."};
};

struct DeviceFlags : OptionSet {
  explicit DeviceFlags(OptionSet& command);

  Value<gl::DeviceChoice> device{
      *this,
      "--device",
      "N|cuda:N|NAME",
      parse_device,
      "The GPU to use: its number, its number in CUDA, or a part of its name; 'isoextract devices' lists them "
      "(default: the first that is not software).",
      About::gpu};
  Value<std::uint64_t> gpu_memory{
      *this,
      "--gpu-memory",
      "SIZE",
      parse_size,
      "What samples and triangles may take on the GPU at a time; larger volumes pass through in slabs, and the "
      "output does not depend on it (default: a quarter of what the GPU has, 1G where it does not tell).",
      About::gpu};
};

// Of a command that compares backends.
struct BackendsOption : Value<std::vector<NamedBackend>> {
  BackendsOption(const Place& place, std::string_view by_default)
      : Value(
            place, "--backends", "B,B,...", parse_backends,
            fmt::format("Of cpu, gpu, gpu:points (marching cubes without tessellation) and gpu:rows (cells row by row "
                        "instead of in groups of 2 x 2 x 2) (default: {}).",
                        by_default),
            About::extraction) {}
};

struct JsonFlag : Flag {
  explicit JsonFlag(const Place& place, std::string help = "Report as JSON.")
      : Flag(place, "--json", std::move(help)) {}
};

// Of a command that reads files.
struct MemoryLimit : Value<std::uint64_t> {
  explicit MemoryLimit(const Place& place)
      : Value(place, "--memory-limit", "SIZE", parse_size,
              "Refuse an input that needs more memory than this, such as 512M or 8G (default: the machine's memory). "
              "Samples that are mapped from their file, not copied, need none.") {}
};

}  // namespace isoextract::cli
