// isoextract's extractor beside VTK's and OpenVDB's, in one process, on the same samples in memory, in alternating
// rounds; and beside plain reading and writing of as many bytes.
//
//   scripts/setup.sh bench                                    VTK, OpenVDB and vdb_tool
//   cmake --preset bench && cmake --build --preset bench
//   build/bench/extraction_benchmark                          all inputs at 256^3 and 512^3
//   build/bench/extraction_benchmark --fields sphere --sizes 1024 --types u8 --peers FlyingEdges3D
//   build/bench/extraction_benchmark --self --fields gyroid --sizes 256,512,1024    threads, and growth with the bytes
//
// Each contestant first runs once, which is reported apart, then all run in turn, so that a disturbance hits all of
// them. --runs sets the number of rounds (default: 7). The clock measures the extraction only; outputs are freed off
// the clock. A ratio is the median of the ratios of all rounds, below 1 if isoextract was faster. A first run is cold
// only for the first input of a process, because isoextract keeps memory for the next. The rows "read samples once" and
// "write output once" only touch memory: an extraction takes at least their sum. --json writes every round.
//
// benchmark_inputs.cpp lists the inputs; another program is a Contestant (contestant.hpp). scripts/compare_speed.py
// compares whole commands from file to file, and `isoextract bench` compares the program's own error and time.
#include <algorithm>
#include <charconv>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "bench/benchmark_report.hpp"

namespace isoextract::bench {
namespace {

struct Options {
  std::vector<std::string> fields{"sphere", "gyroid", "marschner-lobb", "ct", "mri", "level-set", "fog"};
  std::vector<int> sizes{256, 512};
  std::vector<std::string> types{"f32"};
  std::vector<std::string> normals{"none"};
  std::vector<std::string> methods{"mc"};
  std::vector<std::string> peers{"FlyingEdges3D", "MarchingCubes", "volumeToMesh", "VolumeToMesh-pools"};
  std::vector<int> threads;
  int rounds = 7;
  bool self = false;
  std::string json;
  std::vector<std::string> raw;
};

bool contains(const std::vector<std::string>& list, std::string_view word) {
  return std::ranges::find(list, word) != list.end();
}

// What is asked for, of formulas; what they have, of others, and float beside the integers of files.
std::vector<field::SampleType> types_of(const InputDescription& description, field::SampleType own,
                                        const Options& options) {
  std::vector<field::SampleType> types;
  const bool free = description.source == Source::formula || description.source == Source::random;
  if (!free) types.push_back(own);
  for (const std::string& name : options.types) {
    const field::SampleType type = *value_of<field::SampleType>(name);
    const bool possible = free || (description.source == Source::file && type == field::SampleType::f32);
    if (possible && std::ranges::find(types, type) == types.end()) types.push_back(type);
  }
  return types;
}

class Benchmark {
 public:
  explicit Benchmark(const Options& options) : options_(options) {}

  void run() {
    fmt::print("{}", machine_line());
    for (const std::string& name : options_.fields) {
      const InputDescription& description = find_input(name);
      const bool sized = description.source == Source::formula || description.source == Source::vdb;
      for (const int size : sized ? options_.sizes : std::vector<int>{0}) measure(description, size);
    }
    fmt::print("{}", growth_table(groups_));
    if (options_.json.empty()) return;
    std::ofstream file(options_.json);
    file << report_json(groups_, options_.rounds).dump(2) << '\n';
    if (!file.flush()) throw std::runtime_error(fmt::format("cannot write {}", options_.json));
  }

 private:
  void measure(const InputDescription& description, int size) {
    const std::optional<BenchmarkInput> made = make_input(description, size);
    if (!made) {
      fmt::print("\n{}: left out, {} is not there; ISOEXTRACT_DATA may name the data folder\n", description.name,
                 description.origin);
      return;
    }
    for (const field::SampleType type : types_of(description, made->field.type(), options_)) {
      const BenchmarkInput input = made->grid ? *made : with_type(*made, type);
      for (const std::string& normals : options_.normals) measure(input, normals == "smooth");
    }
  }

  void measure(const BenchmarkInput& input, bool smooth_normals) {
    if (options_.self) {
      measure(input, smooth_normals, options_.threads);
    } else {
      for (const int threads : options_.threads) measure(input, smooth_normals, {threads});
    }
  }

  void measure(const BenchmarkInput& input, bool smooth_normals, const std::vector<int>& threads) {
    std::vector<Entrant> entrants;
    for (const int count : threads) {
      for (const extract::MethodInfo& method : extract::kMethods) {
        if (!contains(options_.methods, method.id)) continue;
        if (smooth_normals && !method.traits.gradient_normals) continue;
        entrants.push_back(enter(isoextract_contestant(input, method.method, smooth_normals), count, 0));
      }
    }
    if (!options_.self) add_peers(input, smooth_normals, threads.front(), entrants);
    const std::uint64_t output_bytes = entrants.front().first.bytes_written;
    const std::size_t isoextract =
        static_cast<std::size_t>(std::ranges::find(entrants, threads.back(), &Entrant::threads) - entrants.begin());
    entrants.push_back(enter(memory_reader(input), threads.back(), isoextract));
    entrants.push_back(enter(memory_writer(output_bytes), threads.back(), isoextract));

    const std::uint64_t samples = sample_bytes(input) / field::sample_size(input.field.type());
    Group group{input.name,
                input.size,
                input.field.extents().dims(),
                std::string(field::sample_type_name(input.field.type())),
                smooth_normals,
                samples,
                run_rounds(entrants, options_.rounds)};
    const std::size_t count = group.rows.size();
    group.rows.push_back(
        sum_of(group.rows[count - 2], group.rows[count - 1], "read and write", group.rows[isoextract]));
    fmt::print("{}", group_table(group));
    std::fflush(stdout);
    groups_.push_back(std::move(group));
  }

  void add_peers(const BenchmarkInput& input, bool smooth_normals, int threads, std::vector<Entrant>& entrants) const {
    Contestants peers = vtk_contestants(input, smooth_normals);
    // OpenVDB's mesher has no normals, so there is nothing to compare with smooth ones.
    if (!smooth_normals) std::ranges::move(openvdb_contestants(input), std::back_inserter(peers));
    for (std::unique_ptr<Contestant>& peer : peers) {
      if (contains(options_.peers, peer->name())) entrants.push_back(enter(std::move(peer), threads, 0));
    }
  }

  const Options& options_;
  std::vector<Group> groups_;
};

void write_raw_file(const std::vector<std::string>& words) {
  int size = 0;
  if (std::from_chars(words[1].data(), words[1].data() + words[1].size(), size).ec != std::errc{}) {
    throw std::runtime_error(fmt::format("--write-raw: expected a size, found '{}'", words[1]));
  }
  const InputDescription& description = find_input(words[0]);
  if (description.source != Source::formula) {
    throw std::runtime_error(fmt::format("--write-raw: '{}' has no formula", words[0]));
  }
  write_raw(*make_input(description, size), words[2]);
}

int run_program(int argc, char** argv) {
  Options options;
  const int all = static_cast<int>(std::thread::hardware_concurrency());
  options.threads = {1};
  if (all > 1) options.threads.push_back(all);
  std::vector<std::string> names;
  for (const InputDescription& description : benchmark_inputs()) names.emplace_back(description.name);

  const auto methods = extract::method_ids();

  CLI::App app("Times isoextract's extractor beside VTK's and OpenVDB's on the same samples in memory");
  app.option_defaults()->delimiter(',')->always_capture_default();
  app.add_option("--fields", options.fields, "Inputs")->check(CLI::IsMember(names));
  app.add_option("--sizes", options.sizes, "Samples along an axis; not of files, nor of noise, which has 128")
      ->check(CLI::Range(2, 2048));
  app.add_option("--types", options.types, "Sample types of formulas; files keep theirs, and f32 is tried beside it")
      ->check(CLI::IsMember({"f32", "u8", "i8", "u16", "i16"}));
  app.add_option("--normals", options.normals, "none, smooth")->check(CLI::IsMember({"none", "smooth"}));
  app.add_option("--methods", options.methods, "isoextract's methods")
      ->check(CLI::IsMember(std::vector<std::string>(methods.begin(), methods.end())));
  app.add_option("--peers", options.peers, "Whom to compare with")->check(CLI::IsMember(options.peers));
  app.add_option("--threads", options.threads, "Numbers of threads")->check(CLI::Range(1, all));
  app.add_option("--runs", options.rounds, "Alternating rounds, after a first run of each")->check(CLI::Range(1, 1000));
  app.add_flag("--self", options.self, "isoextract alone, all numbers of threads in the same rounds");
  app.add_option("--json", options.json, "Write all figures to this file");
  app.add_option("--write-raw", options.raw, "Write the f32 samples of FIELD SIZE to FILE, and measure nothing")
      ->expected(3);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  }
  if (!options.raw.empty()) {
    write_raw_file(options.raw);
  } else {
    Benchmark(options).run();
  }
  return 0;
}

}  // namespace
}  // namespace isoextract::bench

int main(int argc, char** argv) {
  try {
    return isoextract::bench::run_program(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "extraction_benchmark: {}\n", error.what());
    return 1;
  }
}
