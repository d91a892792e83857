#include "batch/detail/animation.hpp"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "batch/frame_range.hpp"
#include "convert/mesh_normals.hpp"
#include "convert/output_checks.hpp"
#include "files/content_hash.hpp"
#include "files/frame_pattern.hpp"
#include "files/output_file.hpp"

namespace isoextract::batch {
namespace {

constexpr int kNodeDigits = 4;

// Keys of an animation's records differ from the hashes of jobs, whose frames have files of their own.
std::string key_of(const BatchJob& batch) { return animation_key(hash_of(batch)); }

std::string key_of(const std::string& animation, const FrameJob& frame) {
  return files::content_hash(fmt::format("{} frame {}", animation, frame.number));
}

std::vector<std::int64_t> numbers_of(const BatchJob& batch) {
  std::vector<std::int64_t> numbers;
  for (const FrameJob& frame : batch.frames) numbers.push_back(frame.number);
  return numbers;
}

mesh_io::MeshWriteOptions write_options(const BatchJob& batch) {
  const convert::ConversionJob& job = batch.frames.front().job;
  const convert::MeshFileOptions meshes = job.meshes();
  return {meshes.format, job.normals == convert::Normals::flat, meshes.ascii, {}, copies_vertices(job)};
}

}  // namespace

Animation::Animation(const BatchJob& batch, const Context& context, std::uint64_t largest_file)
    : batch_(batch),
      writer_(batch.animation->path, write_options(batch), batch.animation->frames_per_second, batch.frames.size(),
              context, largest_file) {
  writer_.set_span(batch.frames.front().number, batch.frames.back().number);
  if (!batch.animation->starts.empty()) writer_.set_starts(numbers_of(batch), batch.animation->starts);
}

Result<void> Animation::check() const {
  TRY(writer_.check());
  TRY(writer_.check_times(numbers_of(batch_)));
  files::InputFileSet read;
  if (std::error_code none; std::filesystem::exists(batch_.animation->path, none)) {
    for (const FrameJob& frame : batch_.frames) convert::add_read_files(read, frame.job, Context());
  }
  return convert::check_output_file(batch_.animation->path, read);
}

Result<std::vector<mesh_io::PackedFacts>> Animation::take(std::size_t frame, const convert::MeshCollector& collected) {
  const std::int64_t number = batch_.frames[frame].number;
  const std::string stem = std::filesystem::path(batch_.animation->path).stem().string();
  auto added = writer_.add(fmt::format("{}_{}", stem, files::frame_digits(number, kNodeDigits)), number,
                           collected.meshes, collected.packing, collected.placement);
  if (!added && writer_.has_failed()) {
    const std::lock_guard lock(mutex_);
    lost_ = added.error();
  }
  if (!added) return tl::unexpected(std::move(added.error()));
  is_empty_ = is_empty_ && collected.meshes.empty();
  const auto packed = writer_.packed();
  return std::vector(packed.begin(), packed.end());
}

std::optional<Error> Animation::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

Result<mesh_io::MeshWriteResult> Animation::finish() {
  if (!is_empty_) return writer_.finish();
  const auto removed = TRY(files::remove_old_file(batch_.animation->path));
  return mesh_io::MeshWriteResult{
      {},
      {{NoteId::no_surface, fmt::format("no frame has a surface; the run did not write {}{}", batch_.animation->path,
                                        removed ? " and removed the old file" : "")}},
      {}};
}

std::string missing_frames_note(const BatchJob& batch, std::span<const std::int64_t> missing) {
  std::size_t leading = 0;  // failed frames before the first frame in the file
  while (leading < missing.size() && missing[leading] == batch.frames[leading].number) ++leading;
  const auto list = [](std::span<const std::int64_t> frames) { return text_of(runs_of(frames), kShownFrameRuns); };
  std::string shown = "the animation shows the preceding frame during their time";
  if (leading == missing.size()) {
    shown = "the animation shows nothing during their time, because no frame precedes them";
  } else if (leading > 0) {
    shown = fmt::format(
        "the animation shows nothing during the time of {}, and the preceding frame during the time of the others",
        list(missing.first(leading)));
  }
  return fmt::format("{} lacks the frames that failed: {}; {}", batch.animation->path, list(missing), shown);
}

std::string animation_key(const std::string& batch) { return files::content_hash("animation " + batch); }

Result<void> record_animation(Manifest& manifest, const BatchJob& batch, std::vector<FrameRecord> frames,
                              const mesh_io::MeshWriteResult& written) {
  const std::string key = key_of(batch);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].job = key_of(key, batch.frames[i]);
    TRY(manifest.add(frames[i]));
  }
  // Last, because the other records count only with this one.
  convert::Outcome whole;
  whole.files = written.files;
  auto record = TRY(record_of(batch.frames.front(), {}, whole, Context()));
  record.job = key;
  return manifest.add(record);
}

std::optional<std::vector<FrameRecord>> find_animation_record(const Manifest& manifest, const BatchJob& batch) {
  const std::string key = key_of(batch);
  const FrameRecord* const whole = manifest.find(key);
  if (whole == nullptr || !changed_file_message(*whole).empty()) return std::nullopt;
  // The animation had no surface, so no file was written: an existing file is not this animation.
  std::error_code none;
  if (whole->outputs.empty() && std::filesystem::exists(batch.animation->path, none)) return std::nullopt;
  std::vector<FrameRecord> frames;
  for (const FrameJob& frame : batch.frames) {
    const FrameRecord* const record = manifest.find(key_of(key, frame));
    if (record == nullptr || !knows_inputs(*record, frame)) return std::nullopt;
    if (!changed_file_message(*record).empty() || !added_input_message(*record, frame).empty()) return std::nullopt;
    frames.push_back(*record);
    frames.back().outputs = whole->outputs;
  }
  return frames;
}

}  // namespace isoextract::batch
