#include "batch/batch_job.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "convert/mesh_pieces.hpp"
#include "convert/output_checks.hpp"
#include "files/content_hash.hpp"

namespace isoextract::batch {

namespace {

std::string text_of(const FrameHash& frame) { return fmt::format("{} {}\n", frame.number, frame.job); }

}  // namespace

std::vector<std::filesystem::path> files_of(const convert::ConversionJob& job) {
  std::vector<std::filesystem::path> files;
  for (const convert::OutputFileJob& output : job.outputs) {
    const convert::OutputFileJob first{convert::piece_path(output.path, 1), output.isos};
    for (std::filesystem::path& file : convert::mesh_files(first, job.meshes().format))
      files.push_back(std::move(file));
  }
  return files;
}

std::vector<double> animation_starts(std::span<const std::int64_t> numbers,
                                     std::span<const particle_io::FrameTime> times, double frames_per_second) {
  constexpr double kEven = 1e-3;  // frames
  const auto has_time = [](const particle_io::FrameTime& frame) { return frame.time.has_value(); };
  if (numbers.size() < 3 || times.size() != numbers.size() || !std::ranges::all_of(times, has_time)) return {};
  const auto later = [](const particle_io::FrameTime& a, const particle_io::FrameTime& b) {
    return *a.time >= *b.time;
  };
  if (std::ranges::adjacent_find(times, later) != times.end()) return {};
  const double first = *times.front().time;
  const double frames_per_time = static_cast<double>(numbers.back() - numbers.front()) / (*times.back().time - first);
  std::vector<double> starts;
  bool is_even = true;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const double frames = (*times[i].time - first) * frames_per_time;
    is_even = is_even && std::abs(frames - static_cast<double>(numbers[i] - numbers.front())) < kEven;
    starts.push_back(frames / frames_per_second);
  }
  return is_even ? std::vector<double>() : starts;
}

std::string hash_of(const BatchJob& batch) {
  std::string text;
  for (const FrameJob& frame : batch.frames) text += text_of(FrameHash{frame.number, convert::hash_of(frame.job)});
  if (batch.animation) text += fmt::format("{} {}\n", batch.animation->frames_per_second, batch.animation->path);
  if (batch.animation && !batch.animation->starts.empty()) {
    text += fmt::format("{}\n", fmt::join(batch.animation->starts, " "));
  }
  return files::content_hash(text);
}

std::string hash_of(std::span<const FrameHash> frames) {
  std::string text;
  for (const FrameHash& frame : frames) text += text_of(frame);
  return files::content_hash(text);
}

}  // namespace isoextract::batch
