#include "batch/batch_job.hpp"

#include <fmt/format.h>

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

std::string hash_of(const BatchJob& batch) {
  std::string text;
  for (const FrameJob& frame : batch.frames) text += text_of(FrameHash{frame.number, convert::hash_of(frame.job)});
  if (batch.animation) text += fmt::format("{} {}\n", batch.animation->frames_per_second, batch.animation->path);
  return files::content_hash(text);
}

std::string hash_of(std::span<const FrameHash> frames) {
  std::string text;
  for (const FrameHash& frame : frames) text += text_of(frame);
  return files::content_hash(text);
}

}  // namespace isoextract::batch
