// Options that several commands have: help, run, GPU, backends, JSON and the memory limit.
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

// The options that ask for help. Every command has them, and so does the program without a command.
struct HelpOptions : OptionSet {
  explicit HelpOptions(OptionSet& command) : OptionSet(command, OptionGroup::run) {}

  HelpFlag summaries{*this, "-h,--help", HelpDetail::summaries, "Show the help and exit."};
  HelpFlag all{*this, "--help-all", HelpDetail::all, "Show the whole text of each option and exit."};
};

// The last options of every command.
struct RunFlags : OptionSet {
  // The options that a command takes. Each value includes the options of the values before it: `quiet` has --quiet,
  // `verbosity` adds --no-note and --verbose, `all` adds --threads.
  enum class Taken { help, quiet, verbosity, all };

  explicit RunFlags(OptionSet& command, Taken taken = Taken::all);

 private:
  Taken taken_;
  Place from(Taken least) { return taken_ >= least ? Place(*this) : Place(); }

 public:
  Value<int> threads{from(Taken::all), "--threads", "N", parse_thread_count,
                     "Number of threads (default: all). The output does not depend on it. With 1 only the progress "
                     "display, the GPU and MPI have threads of their own."};
  Flag quiet{from(Taken::quiet), "-q,--quiet", "Print only errors, and results that go to stdout."};
  Value<std::vector<NoteId>> no_note{from(Taken::verbosity), "--no-note", "ID,ID,...", parse_note_ids,
                                     "Hide the notes of these ids. A note shows its id: 'note[open-mesh]: ...'. "
                                     "'isoextract help notes' lists all ids; "
                                     "reports keep every note."};
  Flag verbose{from(Taken::verbosity), "-v,--verbose", "Print run times and the peak memory."};
  HelpOptions help{*this};
};

struct DeviceFlags : OptionSet {
  explicit DeviceFlags(OptionSet& command);

  Value<gl::DeviceChoice> device{
      *this,
      "--device",
      "N|cuda:N|NAME",
      parse_device,
      "GPU to use, by number, CUDA number or name. A part of the name is enough; 'isoextract devices' lists the GPUs. "
      "Default: the first that is not a software renderer, else the first of all.",
      About::gpu};
  Value<std::uint64_t> gpu_memory{
      *this,
      "--gpu-memory",
      "SIZE",
      parse_memory_size,
      "Limit of GPU memory for samples and triangles. Larger volumes are extracted in slabs; the output does not "
      "depend on it. Default: a quarter of the GPU's memory, 1G where the GPU does not tell.",
      About::gpu};
};

// The option of commands that compare backends.
struct BackendsOption : Value<std::vector<NamedBackend>> {
  BackendsOption(const Place& place, std::string_view by_default)
      : Value(place, "--backends", "B,B,...", parse_backends,
              fmt::format("Backends to compare. Any of cpu, gpu, gpu:points (marching cubes without tessellation) and "
                          "gpu:rows (cells row by row instead of in groups of 2 x 2 x 2). Default: {}.",
                          by_default),
              About::extraction) {}
};

struct JsonFlag : Flag {
  explicit JsonFlag(const Place& place, std::string help = "Report as JSON.")
      : Flag(place, "--json", std::move(help)) {}
};

// The option of commands that read files.
struct MemoryLimit : Value<std::uint64_t> {
  explicit MemoryLimit(const Place& place)
      : Value(place, "--memory-limit", "SIZE", parse_memory_size,
              "Limit for samples and meshes, such as 512M or 8G. An input that needs more is refused. Samples that are "
              "mapped "
              "from their file do not count. Default: the memory that the machine or its container allows.") {}
};

}  // namespace isoextract::cli
