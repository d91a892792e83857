// `isoextract bench`: error against run time, as a table on stdout, and as CSV, JSON and a picture.
#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/machine.hpp"
#include "base/printable.hpp"
#include "base/stopwatch.hpp"
#include "cli/bench_report.hpp"
#include "cli/gnuplot.hpp"
#include "cli/gpu_threads_report.hpp"
#include "cli/planned_command.hpp"
#include "cli/progress_bar.hpp"
#include "convert/json_values.hpp"
#include "convert/output_checks.hpp"
#include "convert/particle_source.hpp"
#include "convert/source.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

class Bench {
 public:
  Bench(const BenchPlan& plan, const Messages& messages) : plan_(plan), messages_(messages), options_(plan.options) {}

  Result<void> run() {
    TRY(check());
    const Result<void> done = plan_.gpu_threads ? measure_gpu_threads() : measure_inputs();
    if (done) messages_.detail(fmt::format("peak memory {}", format_byte_size(peak_memory())));
    return done;
  }

 private:
  Result<void> measure_inputs() {
    TRY(choose_backends());
    for (const std::string& input : plan_.inputs) {
      const Stopwatch watch;
      auto result = TRY(input.starts_with(field::kDemoPrefix) ? measure_demo(input) : measure_file(input));
      tell_time(printable(input), watch);
      const std::string before = results_.empty() ? "" : "\n";
      TRY(print_to_stdout(before + bench_table(result, plan_.options.repeats)));
      results_.push_back(std::move(result));
    }
    return write();
  }

  void tell_time(const std::string& what, const Stopwatch& watch) const {
    messages_.detail(fmt::format("{}: measured in {:.2f} s", what, watch.elapsed().wall_seconds));
  }

  // Checks all output files and gnuplot before the measurements.
  [[nodiscard]] Result<void> check() const {
    std::vector<std::string> files;
    files::InputFileSet read;
    for (const std::string& input : plan_.inputs) {
      convert::ConversionJob job;
      job.source.input = input;
      job.source.read = plan_.read;
      convert::add_read_files(read, job, Context());
    }
    for (const auto& file : {plan_.csv, plan_.json, plan_.plot}) {
      if (!file) continue;
      TRY(convert::check_output_file(*file, read));
      for (const std::string& other : files) {
        if (!files::is_same_output(*file, other)) continue;
        return fail(ErrorCode::usage, fmt::format("{}: two options name this output file", *file),
                    "choose another name for one of the two");
      }
      files.push_back(*file);
    }
    return plan_.plot ? check_gnuplot(BenchFlags().plot.name()) : Result<void>();
  }

  Result<void> measure_gpu_threads() const {
    const Stopwatch watch;
    const auto result = TRY(gpu::measure_thread_creation(plan_.gpu.device, plan_.sizes, plan_.options.repeats));
    tell_time("threads of the GPU", watch);
    TRY(print_to_stdout(gpu_threads_table(result, plan_.options.repeats)));
    if (plan_.json) {
      const std::string json = convert::json_text(gpu_threads_json(result, plan_.options.repeats));
      TRY(files::write_file(*plan_.json, json));
      messages_.summary(fmt::format("-> {}", *plan_.json));
    }
    for (const gpu::ThreadCreationLevel& level : result.levels) {
      const auto failed = std::ranges::find_if(level.makers, [](const auto& row) { return row.problem.has_value(); });
      if (failed == level.makers.end()) continue;
      return fail(ErrorCode::unavailable, fmt::format("{}^3 cells: {}", level.size, *failed->problem),
                  "choose smaller grids with --sizes");
    }
    return {};
  }

  // Opens the backends given by option; by default the CPU, and a GPU unless it renders in software.
  Result<void> choose_backends() {
    if (plan_.backends) {
      options_.backends = TRY(open_backends(*plan_.backends));
      return {};
    }
    options_.backends.push_back({"cpu", extract::make_cpu_extractor(), {}});
    auto gpu = convert::open_backend(convert::Backend::automatic, {plan_.gpu});
    if (gpu && gpu->extractor->name() == word_of(convert::Backend::gpu)) {
      options_.backends.push_back({"gpu", std::move(gpu->extractor), {}});
    }
    return {};
  }

  Result<bench::BenchResult> measure_demo(const std::string& input) const {
    const auto spec = TRY(field::parse_demo_spec(input));
    const Context context{plan_.memory};
    const ProgressBar bar(context.progress(), bar_wanted());
    bench::BenchOptions options = options_;
    if (plan_.iso) {
      options.iso = *plan_.iso;
    } else {
      options.iso = std::ranges::find(field::demo_fields(), spec.name, &field::DemoDescription::name)->iso;
    }
    return bench::bench_demo(spec.name, plan_.sizes, options, context);
  }

  // Refuses particles: coarser versions of their field are not fields of these particles.
  [[nodiscard]] Result<void> check_volume(const std::string& input, const Context& context) const {
    convert::SourceOptions source;
    source.input = input;
    source.read = plan_.read;
    if (!convert::is_particles(source, context).value_or(false)) return {};  // the reader reports other errors
    return fail(ErrorCode::usage,
                fmt::format("{}: expected a volume, found particles: bench compares resolutions of a volume's samples, "
                            "and particles have no samples",
                            printable(files::input_label(input))),
                "convert with --report FILE for the time of each stage, and with --error for the error of the mesh");
  }

  Result<bench::BenchResult> measure_file(const std::string& input) const {
    std::optional<field::ScalarField> field;
    const Context context{plan_.memory};
    TRY(check_volume(input, context));
    {
      const ProgressBar bar(context.progress(), bar_wanted());
      convert::Events unheard;
      field = TRY(convert::read_field(input, plan_.read, context, unheard));
    }
    for (const Note& text : field->notes) messages_.note(text);
    const std::vector<int> factors = factors_for(*field);
    const ProgressBar bar(context.progress(), bar_wanted());
    bench::BenchOptions options = options_;
    options.iso = *plan_.iso;
    return bench::bench_field(*field, factors, options, context);
  }

  // Returns the plan's coarsening factors, or by default those that leave enough samples; then 1 for the data
  // unchanged.
  [[nodiscard]] std::vector<int> factors_for(const field::ScalarField& field) const {
    std::vector<int> factors = plan_.coarser;
    if (factors.empty()) {
      constexpr int kFewest = 8;
      const glm::i64vec3 dims = field.extents().dims();
      const std::int64_t smallest = std::min({dims.x, dims.y, dims.z});
      for (const int factor : {8, 4, 2}) {
        if (smallest / factor >= kFewest) {
          factors.push_back(factor);
        } else {
          messages_.note(
              {NoteId::not_coarsened,
               fmt::format("{}: bench does not coarsen by {}, because fewer than {} samples would remain along an axis",
                           field.source, factor, kFewest)});
        }
      }
    }
    factors.push_back(1);
    return factors;
  }

  [[nodiscard]] Result<void> write() const {
    std::optional<std::string> picture;
    const bool drawn = plan_.plot && measured();
    if (plan_.plot && !drawn)
      messages_.note(
          {NoteId::no_plot, fmt::format("{}: bench draws no plot, because it measured no error", *plan_.plot)});
    if (drawn) {
      picture = TRY(run_gnuplot(error_plot_script(results_, plan_.options.repeats, plan_.picture)));
    }
    if (plan_.csv) {
      TRY(files::write_file(*plan_.csv, bench_csv(results_)));
    }
    if (plan_.json) {
      if (auto written =
              files::write_file(*plan_.json, convert::json_text(bench_json(results_, plan_.options.repeats)));
          !written) {
        return written;
      }
    }
    if (picture) {
      TRY(files::write_file(*plan_.plot, *picture));
    }
    for (const auto& file : {plan_.csv, plan_.json, drawn ? plan_.plot : std::nullopt}) {
      if (file) messages_.summary(fmt::format("-> {}", *file));
    }
    return {};
  }

  // Returns whether at least one error was measured.
  [[nodiscard]] bool measured() const {
    return std::ranges::any_of(results_, [](const bench::BenchResult& result) {
      return std::ranges::any_of(result.rows, [](const bench::BenchRow& row) { return row.position.has_value(); });
    });
  }

  [[nodiscard]] bool bar_wanted() const { return messages_.verbosity() != Verbosity::quiet; }

  const BenchPlan& plan_;
  const Messages& messages_;
  bench::BenchOptions options_;  // including the opened backends
  std::vector<bench::BenchResult> results_;
};

class BenchCommand final : public CommandOf<BenchFlags> {
 public:
  BenchCommand() : CommandOf({"bench", "[INPUT...] [options]", "Measure error against run time, method by method."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    apply_in_process(flags().input);
    const MessageChoice shown = TRY(plan_messages(flags().run));
    const BenchPlan plan = TRY(plan_bench(flags()));
    if (!plan.gpu_threads) {
      // Limits the threads to the largest number compared, because oneTBB would start more after a comparison with
      // fewer.
      TRY(limit_threads(std::ranges::max(plan.options.threads)));
    }
    TRY(Bench(plan, Messages(shown)).run());
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_bench_command() { return std::make_unique<BenchCommand>(); }

}  // namespace isoextract::cli
