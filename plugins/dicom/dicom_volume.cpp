// DICOM through GDCM: a folder, one file of a series, a list of slices, or a DICOMDIR.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <gdcmTrace.h>

#include "dicom_parts.hpp"

namespace isoextract_dicom {
namespace {

using isoextract_plugin::Grid;
using isoextract_plugin::HostMemory;
using isoextract_plugin::ReadFacts;
using isoextract_plugin::Request;

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) {
    if (!part.empty()) text += (text.empty() ? "" : "; ") + part;
  }
  return text;
}

void check_problem(const Series& series) {
  if (series.is_uneven) throw isoextract_plugin::UnevenError(series.problem);
  if (!series.problem.empty()) throw ReadError(series.problem);
}

// Decodes the slices of one series, one at a time, into samples of the grid's type.
class SliceReader {
 public:
  SliceReader(const Series& series, const std::vector<Slice>& slices) : series_(series), slices_(slices) {}

  // Fills `box` with the part of a slice that the selection has in x and y.
  void read(std::size_t slice, const isoextract_volume_selection& selection, void* box) {
    const Slice& wanted = slices_[slice];
    const Pixels& pixels = wanted.object->pixels;
    if (!reader_ || open_ != wanted.object.get()) {
      reader_.reset();
      reader_ = std::make_unique<PixelReader>(pixels);
      open_ = wanted.object.get();
    }
    const void* data = reader_->frame(wanted.frame.index).data();
    if (series_.converts) data = converted(pixels, wanted.frame, data);
    isoextract_volume_selection part = selection;
    part.first[2] = 0;
    part.count[2] = 1;
    part.box = box;
    const auto columns = static_cast<std::int64_t>(pixels.columns);
    const auto components = static_cast<std::int64_t>(pixels.samples_per_pixel);
    isoextract_plugin::SamplesInMemory from =
        isoextract_plugin::interleaved_samples(data, series_.grid.dims, pixels.samples_per_pixel);
    if (pixels.planar && components > 1) from = {data, {1, columns, 0}, columns * pixels.rows};
    isoextract_plugin::fill_box(series_.grid, from, part);
  }

 private:
  const void* converted(const Pixels& pixels, const Frame& frame, const void* data) {
    const auto convert = [&]<class To>(std::vector<To>& values) -> const void* {
      values.resize(pixels.samples());
      isoextract_plugin::with_sample_type(sample_type(pixels), [&]<class From>(From) {
        const auto* const from = static_cast<const From*>(data);
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = static_cast<To>(frame.slope * static_cast<double>(from[i]) + frame.intercept);
      });
      return values.data();
    };
    return series_.grid.sample_type == ISOEXTRACT_F64 ? convert(doubles_) : convert(floats_);
  }

  const Series& series_;
  const std::vector<Slice>& slices_;
  std::unique_ptr<PixelReader> reader_;
  const Object* open_ = nullptr;
  std::vector<float> floats_;
  std::vector<double> doubles_;
};

// Interpolates linearly between slices. Keeps the last two decoded slices.
template <class T>
void read_between(SliceReader& reader, const Series& series, const isoextract_volume_selection& selection,
                  const isoextract_plugin_host& host, ReadFacts& facts) {
  const std::uint64_t area = selection.count[0] * selection.count[1];
  std::array<std::vector<T>, 2> kept;
  std::array<std::size_t, 2> numbers{SIZE_MAX, SIZE_MAX};
  const auto slice = [&](std::size_t number) -> const std::vector<T>& {
    const std::size_t place = number % 2;
    if (numbers[place] != number) {
      kept[place].resize(area);
      reader.read(number, selection, kept[place].data());
      numbers[place] = number;
      ++facts.parts_read;
    }
    return kept[place];
  };
  T* to = static_cast<T*>(selection.box);
  for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
    isoextract_plugin::check_cancelled(host);
    const double at = series.slice_positions[selection.first[2] + z];
    const auto below = static_cast<std::size_t>(at);
    const double part = at - static_cast<double>(below);
    if (part == 0) {
      to = std::ranges::copy(slice(below), to).out;
      continue;
    }
    const std::vector<T>& a = slice(below);
    const std::vector<T>& b = slice(below + 1);
    for (std::uint64_t i = 0; i < area; ++i, ++to) *to = static_cast<T>((1 - part) * a[i] + part * b[i]);
  }
}

class DicomFile final : public isoextract_plugin::VolumeFile {
 public:
  DicomFile(const Request& request, const isoextract_plugin_host& host) {
    FoundFiles found = find_files(request, host);
    std::vector<std::string> notes{found.note};
    const auto objects = read_objects(request, found, host, notes);
    format = "DICOM";
    for (const auto& object : objects) {
      if (object->segmentation == Segmentation::none) continue;
      segmentations_.push_back(std::make_unique<SegmentationGrids>(object, host));
      format = "DICOM SEG";
    }
    series_ = make_series(objects, request.resamples, notes);
    if (!series_.empty()) format = "DICOM";
    for (const auto& object : objects) {
      if (creator.empty()) creator = object->device;
    }
    add_grids(notes);
    if (grids.empty())
      throw ReadError("expected DICOM images, found none" + (notes.empty() ? "" : ": " + joined(notes)));
    if (grids.size() == 1 && !series_.empty()) check_problem(series_[0]);
    note = joined(notes);
  }

  ReadFacts read(const isoextract_volume_selection& selection, const isoextract_plugin_host& host) override {
    if (selection.grid >= series_.size()) {
      const auto [object, grid] = segmentation_grids_[selection.grid - series_.size()];
      return segmentations_[object]->read(grid, selection, host);
    }
    const Series& series = series_[selection.grid];
    check_problem(series);
    const std::vector<Slice>& slices = series.volumes[selection.volume];
    HostMemory memory(host);
    const std::uint64_t frame = slices.front().object->pixels.samples() * 8;
    memory.take(3 * frame + (series.slice_positions.empty() ? 0 : 16 * selection.count[0] * selection.count[1]));
    SliceReader reader(series, slices);
    ReadFacts facts;
    facts.parts = slices.size();
    if (grids.size() > 1) facts.note = joined(series.notes);
    const std::int32_t type = isoextract_plugin::selected_type(series.grid, selection);
    if (!series.slice_positions.empty()) {
      if (type == ISOEXTRACT_F64)
        read_between<double>(reader, series, selection, host, facts);
      else
        read_between<float>(reader, series, selection, host, facts);
      return facts;
    }
    const std::uint64_t area = selection.count[0] * selection.count[1] * isoextract_plugin::sample_size(type);
    for (std::uint64_t z = 0; z < selection.count[2]; ++z) {
      isoextract_plugin::check_cancelled(host);
      reader.read(selection.first[2] + z, selection, static_cast<std::byte*>(selection.box) + z * area);
      ++facts.parts_read;
    }
    return facts;
  }

 private:
  using Objects = std::vector<std::shared_ptr<const Object>>;

  Objects read_objects(const Request& request, const FoundFiles& found, const isoextract_plugin_host& host,
                       std::vector<std::string>& notes) {
    namespace fs = std::filesystem;
    Objects objects;
    std::string series;
    if (found.is_single_input) {
      const auto object = read_object(request.path, host);
      if (object == nullptr) throw ReadError("expected a DICOM object with pixels, found no pixels");
      objects.push_back(object);
      // A slice needs the other files of its series; an object of several frames is a volume by itself.
      if (object->pixels.frames > 1 || object->segmentation != Segmentation::none || object->series_uid.empty())
        return objects;
      series = object->series_uid;
    }
    std::size_t without_pixels = 0;
    for (const std::string& path : found.paths) {
      isoextract_plugin::check_cancelled(host);
      std::error_code error;
      if (found.is_single_input && fs::equivalent(path, request.path, error)) continue;
      std::shared_ptr<const Object> object;
      try {
        object = read_object(path, host);
      } catch (const ReadError& problem) {
        const fs::path shown = fs::path(path).lexically_relative(request.path);
        throw ReadError((found.is_single_input || shown.empty() ? fs::path(path).filename() : shown).string() + ": " +
                        problem.what());
      }
      if (object == nullptr) {
        ++without_pixels;
      } else if (!found.is_single_input || object->series_uid == series) {
        objects.push_back(object);
      }
      if (path != request.path && object != nullptr && (!found.is_single_input || object->series_uid == series))
        files.push_back(path);
    }
    if (without_pixels > 0 && !found.is_single_input)
      notes.push_back("the reader skips " + std::to_string(without_pixels) +
                      (without_pixels == 1 ? " object" : " objects") + " without pixels");
    return objects;
  }

  void add_grids(std::vector<std::string>& notes) {
    for (Series& series : series_) grids.push_back(series.grid);
    for (std::size_t i = 0; i < segmentations_.size(); ++i) {
      for (std::size_t k = 0; k < segmentations_[i]->grids.size(); ++k) {
        grids.push_back(segmentations_[i]->grids[k]);
        segmentation_grids_.emplace_back(i, k);
      }
      notes.push_back(segmentations_[i]->note);
    }
    if (grids.size() == 1 && !series_.empty()) {
      notes.insert(notes.end(), series_[0].notes.begin(), series_[0].notes.end());
    }
    for (std::size_t i = 0; i < grids.size(); ++i) {
      const auto same = [&](const Grid& other) { return other.name == grids[i].name; };
      const std::string name = grids[i].name;
      for (int number = 2; std::any_of(grids.begin(), grids.begin() + static_cast<std::ptrdiff_t>(i), same); ++number)
        grids[i].name = name + " #" + std::to_string(number);
    }
  }

  std::vector<Series> series_;
  std::vector<std::unique_ptr<SegmentationGrids>> segmentations_;
  std::vector<std::pair<std::size_t, std::size_t>> segmentation_grids_;  // (segmentation, grid), after the series
};

std::unique_ptr<isoextract_plugin::VolumeFile> open_dicom(const Request& request, const isoextract_plugin_host& host) {
  return std::make_unique<DicomFile>(request, host);
}

bool probe_dicom(const unsigned char* start, std::size_t bytes, const std::string& /*path*/) {
  if (bytes >= 132 && std::equal(start + 128, start + 132, "DICM")) return true;
  // Without the preamble, a file begins with an attribute of group 2 or 8.
  return bytes >= 8 && (start[0] == 2 || start[0] == 8) && start[1] == 0 && start[3] == 0;
}

// GDCM's own messages would print attribute values, including the patient's data.
void silence_gdcm() {
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  gdcm::Trace::DebugOff();
}

}  // namespace
}  // namespace isoextract_dicom

extern "C" const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  static const isoextract_volume_plugin_v4 table = [] {
    isoextract_dicom::silence_gdcm();
    return isoextract_plugin::volume_plugin<isoextract_dicom::open_dicom, isoextract_dicom::probe_dicom>("dicom",
                                                                                                         "DICOM");
  }();
  return &table;
}
