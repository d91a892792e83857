// Runs two conversions at once in one process, without the command line. Each has its own job, context and listener;
// they share one memory budget.
//
//   convert_two INPUT ISO OUTPUT INPUT ISO OUTPUT
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "convert/conversion.hpp"

namespace {

using namespace isoextract;

// Collects messages instead of printing them: the conversions call it on two threads.
class Listener final : public convert::Events {
 public:
  void note(const isoextract::Note& note) override { told += "note: " + note.text + "\n"; }
  void end(const convert::StageReport& report) override {
    if (report.stage == convert::StageName::read && report.time) {
      const auto format = value_at<std::string>(report.entries.front(), {convert::Key::format});
      told += "read " + report.subject + " (" + *format + ") in " + std::to_string(report.time->wall_seconds) + " s\n";
    }
    if (report.output) {
      told += "wrote " + report.subject + ": " + std::to_string(report.output->triangles) + " triangles\n";
    }
  }

  std::string told;
};

struct Conversion {
  convert::ConversionJob job;
  Listener listener;
  convert::Outcome outcome;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 7) {
    std::fputs("usage: convert_two INPUT ISO OUTPUT INPUT ISO OUTPUT\n", stderr);
    return 1;
  }
  const MemoryBudget budget;
  std::array<Conversion, 2> conversions;
  std::array<std::jthread, 2> threads;
  for (std::size_t c = 0; c < conversions.size(); ++c) {
    Conversion& one = conversions[c];
    one.job.source.input = argv[3 * c + 1];
    one.job.outputs = {{argv[3 * c + 3], {std::strtod(argv[3 * c + 2], nullptr)}}};
    one.job.file =
        convert::MeshFileOptions{mesh_io::mesh_format_by_path(argv[3 * c + 3]).value_or(mesh_io::MeshFormat::glb)};
    threads[c] = std::jthread(
        [&one, context = Context(budget.part())] { one.outcome = convert::run(one.job, context, one.listener); });
  }
  for (std::jthread& thread : threads) thread.join();
  int failed = 0;
  for (const Conversion& one : conversions) {
    std::fputs(one.listener.told.c_str(), stdout);
    if (!one.outcome.error) continue;
    std::fprintf(stderr, "%s\n", one.outcome.error->message.c_str());
    failed = exit_code_of(one.outcome.error->code);
  }
  return failed;
}
