// Masks of one grid, one file each, as label maps. Mask k of a list, counted from 0, becomes the label k + 1.
//
// Masks without common voxels share a label map, a layer, so that the surfaces of neighbors meet without gaps. Each
// mask goes into the first layer in which it shares no voxel with an earlier mask, so no voxel of any mask is lost. A
// mask that shares voxels with each of the first eight layers gets a layer of its own. Each layer is a label map, as in
// a segmentation with layers (field::LabelName::layer).
//
// Each mask is read once; masks of later layers are read again for their layer. Memory is the same for 3 masks and for
// 200: layer 0, one later layer at a time, and one mask. While the layers are chosen, it is also a byte for each voxel,
// two if only some masks get a mesh. A layer takes a byte for each voxel, two if there are more than 255 masks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/events.hpp"
#include "convert/iso_choice.hpp"
#include "convert/label_selection.hpp"
#include "field/label_map.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {

// The masks that get a mesh.
class MaskChoice {
 public:
  MaskChoice() = default;  // all masks
  // Chooses the masks of these labels and sets of labels that have `least_voxels` or more.
  MaskChoice(std::span<const IsoChoice> asked, std::uint64_t least_voxels);

  // Returns whether a mask is chosen if it has enough voxels.
  [[nodiscard]] bool names(std::int64_t label, std::string_view name);
  [[nodiscard]] std::uint64_t least_voxels() const { return least_voxels_; }
  // Returns whether all masks that have voxels are chosen.
  [[nodiscard]] bool is_all() const { return all_ && least_voxels_ <= 1; }

 private:
  bool all_ = true;
  std::vector<std::int64_t> labels_;
  std::vector<LabelSelection> selections_;
  std::uint64_t least_voxels_ = 0;
};

class MaskLayers {
 public:
  // Reads the masks at `paths`, at least one, and chooses their layers, which do not depend on `choice`. Samples of a
  // mask are 0 outside and one other value inside, of any type; they may be scaled, but without an offset. Reports to
  // `events` the stage of reading and the notes of each file. Of the masks in `choice`, also notes those without voxels
  // and those that overlap.
  //
  // Fails with ErrorCode::input if a mask has more values or is sparse, and if its shape or placement differs from
  // the first mask's by more than a thousandth of a voxel. Fails with ErrorCode::usage for more than 65535 masks,
  // and as read_volume() does.
  [[nodiscard]] static Result<MaskLayers> read(std::vector<std::string> paths, const volume_io::ReadOptions& options,
                                               MaskChoice choice, const Context& context, Events& events);

  // Returns the name of a mask for messages and meshes: that of its file without folder and extension.
  [[nodiscard]] static std::string name_of(const std::string& path);

  // Returns the numbers of the layers, from 0.
  [[nodiscard]] std::vector<std::optional<std::int64_t>> layers() const;

  // Returns the names of the masks with voxels, with their labels and layers.
  [[nodiscard]] const std::vector<field::LabelName>& names() const { return names_; }
  // Returns the names of the other masks, those without a voxel.
  [[nodiscard]] const std::vector<std::string>& names_without_voxels() const { return empty_; }
  // Returns the voxels and bounds of the masks with voxels, in ascending order of label.
  [[nodiscard]] const std::vector<field::LabelFigures>& figures() const { return figures_; }

  // Returns the number of faces of voxels on the surfaces of all masks.
  [[nodiscard]] std::uint64_t faces() const { return faces_; }

  // Returns a layer as a label map with the background 0. For layers other than 0, fails as read() does, and with
  // ErrorCode::input if the number or the bounds of a mask's voxels have changed since read().
  [[nodiscard]] Result<field::ScalarField> layer(std::int64_t number, const Context& context) const;

 private:
  struct Map;

  std::vector<std::string> paths_;
  volume_io::ReadOptions options_;
  field::ScalarField grid_;                   // of all masks, without samples
  std::vector<field::LabelName> names_;       // of masks with voxels
  std::vector<std::string> empty_;            // names of the masks without voxels
  std::vector<field::LabelFigures> figures_;  // of masks with voxels
  std::uint64_t faces_ = 0;
  std::int64_t count_ = 1;            // of the layers
  std::shared_ptr<const Map> first_;  // the samples of layer 0
};

}  // namespace isoextract::convert
