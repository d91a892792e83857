// Converts frames side by side, and resumes an earlier run that was ended: resumed_batch FOLDER ISO INPUT...
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "batch/batch_run.hpp"
#include "batch/find_frames.hpp"

using namespace isoextract;

class Printer final : public batch::RunEvents {
  void over(std::size_t /*frame*/, const batch::FrameRow& row, convert::Outcome* /*outcome*/,
            const Error* error) override {
    const std::lock_guard lock(mutex_);  // several threads call over()
    fmt::print("frame {}: {}{}\n", row.frame, word_of(row.status), error != nullptr ? ": " + error->message : "");
  }
  std::mutex mutex_;
};

Result<int> convert_frames(const std::filesystem::path& folder, double iso, std::span<const std::string> inputs) {
  const batch::Frames found = TRY(batch::find_frames(inputs, std::nullopt));
  batch::BatchJob job;
  for (const batch::Frame& frame : found.frames) {
    convert::ConversionJob one;
    one.source.input = frame.input;
    one.file = convert::MeshFileOptions{mesh_io::MeshFormat::ply};
    one.normals = convert::Normals::none;
    one.outputs = {{(folder / fmt::format("frame_{:04}.ply", frame.number)).string(), {iso}}};
    job.frames.push_back({frame.number, std::move(one)});
  }
  std::filesystem::create_directories(folder);
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  const Context context;
  auto run = TRY(batch::BatchRun::open(
      job, {.resume_policy = batch::ResumePolicy::keep_unchanged, .scheduler = {.jobs = threads, .threads = threads}},
      context));
  Printer printer;
  const batch::RunResult result = run.run(printer);
  if (result.error) return tl::unexpected(*result.error);
  return result.count(batch::FrameStatus::failed) == 0 ? 0 : exit_code_of(ErrorCode::frames);
}

int main(int argc, char** argv) {
  if (argc < 4) return std::fputs("usage: resumed_batch FOLDER ISO INPUT...\n", stderr), 1;
  const auto done = convert_frames(argv[1], std::atof(argv[2]), std::vector<std::string>(argv + 3, argv + argc));
  if (!done) fmt::print(stderr, "{}\n", done.error().message);
  return done ? *done : exit_code_of(done.error().code);
}
