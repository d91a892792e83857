#include "convert/mask_layers.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "convert/field_label.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// The samples of a layer: the label of each voxel, as u8 or u16.
struct MaskLayers::Map {
  std::shared_ptr<void> owner;
  void* data = nullptr;
  field::SampleType type = field::SampleType::u8;
};

namespace {

constexpr std::size_t kRowsPerTask = 64;
constexpr std::size_t kMostTold = 10;      // names in a note
constexpr std::uint8_t kLayerBits = 0xff;  // of a voxel: one for each of the first layers that has it

// Returns "20 x 16 x 12 samples, steps (1, 0, 0), (0, 1, 0) and (0, 0, 1), first sample at (0, 0, 0)".
std::string grid_text(const field::ScalarField& field) {
  const glm::i64vec3 dims = field.extents().dims();
  const glm::dmat3& steps = field.index_to_world.linear;
  return fmt::format("{} x {} x {} samples, steps {}, {} and {}, first sample at {}", dims.x, dims.y, dims.z,
                     point_text(steps[0]), point_text(steps[1]), point_text(steps[2]),
                     point_text(field.index_to_world.offset));
}

// Returns whether all samples of two fields lie at the same positions, up to the rounding of files.
bool have_same_grid(const field::ScalarField& a, const field::ScalarField& b) {
  const glm::i64vec3 dims = a.extents().dims();
  if (dims != b.extents().dims()) return false;
  constexpr double kPart = 1e-3;  // of a voxel
  const glm::dmat3& steps = a.index_to_world.linear;
  const double step = std::min({glm::length(steps[0]), glm::length(steps[1]), glm::length(steps[2])});
  for (unsigned corner = 0; corner < 8; ++corner) {
    const glm::dvec3 index =
        glm::dvec3(dims - glm::i64vec3(1)) * glm::dvec3(corner & 1U, (corner >> 1U) & 1U, corner >> 2U);
    if (!(glm::distance(a.index_to_world(index), b.index_to_world(index)) <= kPart * step)) return false;
  }
  return true;
}

// Figures of a mask's voxels, and of the voxels that earlier masks have, too.
struct Scan {
  std::uint64_t voxels = 0;
  std::uint64_t faces = 0;   // of voxels, towards other samples and the data boundary
  std::uint64_t shared = 0;  // voxels that earlier chosen masks have
  std::uint8_t layers = 0;   // a bit for each of the first layers that has such a voxel
  field::IndexBox box{glm::ivec3(std::numeric_limits<int>::max()), glm::ivec3(-1)};
  std::size_t other = SIZE_MAX;  // index of the first sample with a third value

  void merge(const Scan& later) {
    voxels += later.voxels;
    faces += later.faces;
    shared += later.shared;
    layers |= later.layers;
    box = {glm::min(box.min, later.box.min), glm::max(box.max, later.box.max)};
    other = std::min(other, later.other);
  }
};

template <class T>
bool is_empty_row(const T* row, int count) {
  bool any = false;
  for (int x = 0; x < count; ++x) any |= row[x] != T(0);  // without a branch, so that it runs on vectors
  return !any;
}

// Returns how many of the six neighbors of a voxel are outside.
template <class T>
std::uint64_t count_faces(const T* voxel, const glm::ivec3& at, const glm::ivec3& dims) {
  const std::array<std::ptrdiff_t, 3> steps{1, dims.x, static_cast<std::ptrdiff_t>(dims.x) * dims.y};
  std::uint64_t faces = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::ptrdiff_t step = steps[static_cast<std::size_t>(axis)];
    faces += at[axis] == 0 || voxel[-step] == T(0) ? 1 : 0;
    faces += at[axis] == dims[axis] - 1 || voxel[step] == T(0) ? 1 : 0;
  }
  return faces;
}

// Facts about the voxels of earlier masks. Null for the only mask.
struct EarlierMasks {
  const std::uint8_t* layers = nullptr;  // the bits of each voxel
  const std::uint8_t* chosen = nullptr;  // not 0: a mask that gets a mesh has the voxel
};

template <class T>
Scan scan(const T* values, const glm::ivec3& dims, T inside, const EarlierMasks& earlier_masks) {
  const auto width = static_cast<std::size_t>(dims.x);
  const std::size_t rows = static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z);
  const auto look = [&](std::size_t begin, std::size_t end, Scan found) {
    for (std::size_t row = begin; row < end; ++row) {
      const T* const samples = values + row * width;
      if (is_empty_row(samples, dims.x)) continue;
      const glm::ivec3 start(0, static_cast<int>(row % static_cast<std::size_t>(dims.y)),
                             static_cast<int>(row / static_cast<std::size_t>(dims.y)));
      for (int x = 0; x < dims.x; ++x) {
        if (samples[x] == T(0)) continue;
        const std::size_t at = row * width + static_cast<std::size_t>(x);
        if (samples[x] != inside) found.other = std::min(found.other, at);
        ++found.voxels;
        if (earlier_masks.layers != nullptr) {
          found.layers |= earlier_masks.layers[at];
          found.shared += earlier_masks.chosen[at] != 0 ? 1 : 0;
        }
        const glm::ivec3 voxel = start + glm::ivec3(x, 0, 0);
        found.faces += count_faces(samples + x, voxel, dims);
        found.box = {glm::min(found.box.min, voxel), glm::max(found.box.max, voxel)};
      }
    }
    return found;
  };
  return reduce_ranges(rows, kRowsPerTask, Scan(), look, [](Scan earlier, const Scan& later) {
    earlier.merge(later);
    return earlier;
  });
}

// Calls set(index of a voxel) for the voxels of a mask, in parallel.
template <class T, class Set>
void for_each_voxel(const T* values, const glm::ivec3& dims, const field::IndexBox& box, const Set& set) {
  if (box.empty()) return;
  const glm::i64vec3 size = box.dims();
  for_each_index(
      size.y * size.z,
      [&](std::int64_t row) {
        const std::int64_t y = box.min.y + row % size.y;
        const std::int64_t z = box.min.z + row / size.y;
        const auto start = static_cast<std::size_t>(dims.x * (y + dims.y * z));
        for (std::size_t at = start + static_cast<std::size_t>(box.min.x);
             at <= start + static_cast<std::size_t>(box.max.x); ++at) {
          if (values[at] != T(0)) set(at);
        }
      },
      kRowsPerTask);
}

// The samples of one mask.
struct Mask {
  field::ScalarField field;
  Scan found;

  [[nodiscard]] const field::DenseSamples& samples() const { return std::get<field::DenseSamples>(field.samples); }
};

template <class T>
Result<Scan> scan_mask(const std::string& label, const field::ScalarField& field, const EarlierMasks& earlier) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  const std::span<const T> values(static_cast<const T*>(samples.data), samples.count());
  const auto first = std::ranges::find_if(values, [](T value) { return value != T(0); });
  const T inside = first != values.end() ? *first : T(0);
  const Scan found = scan(values.data(), samples.dims, inside, earlier);
  if (found.other == SIZE_MAX) return found;
  const auto value = [&](T stored) { return field.scale(static_cast<double>(stored)); };
  const bool is_nan = std::isnan(static_cast<double>(inside));
  const char* const hint = "convert a label map, a scan or probabilities in a run of its own";
  if (is_nan) {
    return fail(ErrorCode::input, fmt::format("{}: expected a mask, with 0 and one other value, found nan", label),
                hint);
  }
  return fail(ErrorCode::input,
              fmt::format("{}: expected a mask, with 0 and one other value, found {} and {}", label, value(inside),
                          value(values[found.other])),
              hint);
}

Result<Mask> read_mask(const std::string& path, const volume_io::ReadOptions& options, const field::ScalarField* grid,
                       const EarlierMasks& earlier, const Context& context, Events& events) {
  Mask mask;
  mask.field = TRY(read_field(path, options, context, events));
  const std::string label = field_label(mask.field);
  if (!std::holds_alternative<field::DenseSamples>(mask.field.samples)) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected the samples of a box for a mask, found a sparse grid", label),
                "write the grid to a .nrrd or .npy file first: isoextract FILE -o NAME.nrrd");
  }
  if (mask.field.scale.intercept != 0) {
    return fail(ErrorCode::input, fmt::format("{}: expected a mask, with 0 and one other value, found scaled samples: "
                                              "value = {:.6g} * stored + {:.6g}",
                                              label, mask.field.scale.slope, mask.field.scale.intercept));
  }
  if (grid != nullptr && !have_same_grid(*grid, mask.field)) {
    return fail(ErrorCode::input,
                fmt::format("the masks {} and {} have different grids: {}; and {}", field_label(*grid), label,
                            grid_text(*grid), grid_text(mask.field)),
                "all masks need one grid; convert the masks of each grid in a run of their own");
  }
  mask.found = TRY(field::visit_sample_type(mask.field.type(), [&]<class T>(std::type_identity<T> /*type*/) {
    return scan_mask<T>(label, mask.field, earlier);
  }));
  TRY(volume_io::check_mapping_intact(mask.field));
  return mask;
}

template <class Set>
void for_each_voxel(const Mask& mask, const Set& set) {
  const field::DenseSamples& samples = mask.samples();
  field::visit_sample_type(samples.type, [&]<class T>(std::type_identity<T> /*type*/) {
    for_each_voxel(static_cast<const T*>(samples.data), samples.dims, mask.found.box, set);
  });
}

template <class T>
Result<std::shared_ptr<ReservedBuffer<T>>> make_zeros(std::size_t count, const Context& context,
                                                      const std::string& what) {
  auto made = TRY(make_reserved_buffer<T>(count, context, what));
  T* const to = made->values.data();
  constexpr std::size_t kSamplesPerTask = std::size_t{1} << 20;
  for_each_range(count, kSamplesPerTask,
                 [&](std::size_t begin, std::size_t end) { std::fill(to + begin, to + end, T(0)); });
  return made;
}

template <class Map>
Result<Map> make_map(const field::ScalarField& grid, std::size_t masks, const Context& context) {
  const std::size_t count = grid.extents().count();
  const std::string what = fmt::format("{}: the label map of all masks", grid.source);
  Map map;
  if (masks <= std::numeric_limits<std::uint8_t>::max()) {
    auto made = TRY(make_zeros<std::uint8_t>(count, context, what));
    map.data = made->values.data();
    map.owner = std::move(made);
    return map;
  }
  auto made = TRY(make_zeros<std::uint16_t>(count, context, what));
  map.data = made->values.data();
  map.owner = std::move(made);
  map.type = field::SampleType::u16;
  return map;
}

template <class Map>
void paint(const Mask& mask, std::int64_t label, Map& map) {
  if (map.type == field::SampleType::u8) {
    auto* const to = static_cast<std::uint8_t*>(map.data);
    for_each_voxel(mask, [&](std::size_t at) { to[at] = static_cast<std::uint8_t>(label); });
  } else {
    auto* const to = static_cast<std::uint16_t*>(map.data);
    for_each_voxel(mask, [&](std::size_t at) { to[at] = static_cast<std::uint16_t>(label); });
  }
}

// Returns "liver, spleen, ..." of printable names.
std::string list_text(std::span<const std::string> names) {
  std::vector<std::string> told;
  for (const std::string& name : names.first(std::min(names.size(), kMostTold))) told.push_back(printable(name));
  return fmt::format("{}{}", fmt::join(told, ", "), names.size() > kMostTold ? ", ..." : "");
}

// The masks that get a mesh, for the notes about them.
class ChosenMasks {
 public:
  explicit ChosenMasks(MaskChoice choice) : choice_(std::move(choice)) {}

  // Returns whether the mask gets a mesh.
  bool add(std::int64_t label, const std::string& name, const Scan& found) {
    if (!choice_.names(label, name)) return false;
    ++named_;
    if (found.voxels == 0) empty_.push_back(name);
    if (found.voxels == 0 || found.voxels < choice_.least_voxels()) return false;
    shared_ += found.shared;
    return true;
  }
  void set_layer(const std::string& name, std::int64_t layer) { placed_.push_back({name, layer}); }

  // `all` starts the notes.
  void tell(const std::string& all, Events& events) const {
    if (!empty_.empty()) {
      events.note({NoteId::labels_empty, fmt::format("{}: no mesh for masks without voxels, {} of {}: {}", all,
                                                     empty_.size(), named_, list_text(empty_))});
    }
    const auto first = std::ranges::min_element(placed_, {}, &Placed::layer);
    std::vector<std::string> apart;  // in other layers
    for (const auto& [name, layer] : placed_) {
      if (layer != first->layer) apart.push_back(name);
    }
    if (apart.empty()) return;
    if (shared_ > 0) {
      events.note(
          {NoteId::masks_overlap,
           fmt::format("{}: {} voxels of masks are in earlier masks, too; each mask keeps all its voxels, so the "
                       "meshes of {} overlap others and share no faces with them: {}",
                       all, shared_, counted(apart.size(), "mask"), list_text(apart))});
      return;
    }
    events.note({NoteId::masks_overlap,
                 fmt::format("{}: masks without a mesh have voxels of others, too, so the meshes of {} share no faces "
                             "with the other meshes: {}",
                             all, counted(apart.size(), "mask"), list_text(apart))});
  }

 private:
  struct Placed {
    std::string name;
    std::int64_t layer = 0;
  };

  MaskChoice choice_;
  std::size_t named_ = 0;           // masks that the choice names, whatever their voxels
  std::vector<std::string> empty_;  // those of them without voxels
  std::vector<Placed> placed_;
  std::uint64_t shared_ = 0;  // voxels that two or more masks have, counted once for each mask after the first
};

}  // namespace

MaskChoice::MaskChoice(std::span<const IsoChoice> asked, std::uint64_t least_voxels)
    : all_(std::ranges::any_of(asked,
                               [](const IsoChoice& choice) { return choice.kind == IsoChoice::Kind::all_labels; })),
      least_voxels_(least_voxels) {
  for (const IsoChoice& choice : asked) {
    if (choice.id.is_label()) labels_.push_back(choice.id.label());
    if (choice.kind != IsoChoice::Kind::selected_labels) continue;
    if (auto selection = LabelSelection::parse(choice.selection)) selections_.push_back(std::move(*selection));
  }
}

bool MaskChoice::names(std::int64_t label, std::string_view name) {
  const auto has = [&](LabelSelection& selection) { return selection.contains(label, name); };
  return all_ || std::ranges::find(labels_, label) != labels_.end() || std::ranges::any_of(selections_, has);
}

std::string MaskLayers::name_of(const std::string& path) {
  return stem_of_file(path.ends_with('/') ? path.substr(0, path.size() - 1) : path);
}

std::vector<std::optional<std::int64_t>> MaskLayers::layers() const {
  std::vector<std::optional<std::int64_t>> numbers;
  for (std::int64_t k = 0; k < count_; ++k) numbers.emplace_back(k);
  return numbers;
}

Result<MaskLayers> MaskLayers::read(std::vector<std::string> paths, const volume_io::ReadOptions& options,
                                    MaskChoice choice, const Context& context, Events& events) {
  constexpr std::size_t kMostMasks = std::numeric_limits<std::uint16_t>::max();
  if (paths.size() > kMostMasks) {
    return fail(ErrorCode::usage, fmt::format("expected at most {} masks, found {}", kMostMasks, paths.size()),
                "convert the masks in several runs");
  }
  MaskLayers masks;
  masks.paths_ = std::move(paths);
  masks.options_ = options;
  std::shared_ptr<ReservedBuffer<std::uint8_t>> occupied;
  std::shared_ptr<ReservedBuffer<std::uint8_t>> has_mesh;  // of each voxel; null if all masks get a mesh
  EarlierMasks earlier;
  Map first;
  const bool has_unchosen = !choice.is_all();
  ChosenMasks chosen(std::move(choice));
  for (std::size_t k = 0; k < masks.paths_.size(); ++k) {
    TRY(context.check());
    const std::string& path = masks.paths_[k];
    const Mask mask = TRY(read_mask(path, options, k > 0 ? &masks.grid_ : nullptr, earlier, context, events));
    if (k == 0) {
      masks.grid_ = mask.field;
      field::DenseSamples& none = std::get<field::DenseSamples>(masks.grid_.samples);
      none.owner.reset();
      none.data = nullptr;
      none.loss = nullptr;
      none.file_backed = false;
      masks.grid_.notes.clear();
      masks.grid_.scale = {};
      masks.grid_.labels.clear();
      first = TRY(make_map<Map>(masks.grid_, masks.paths_.size(), context));
      if (masks.paths_.size() > 1) {
        const std::string what = masks.grid_.source + ": the layers of the masks";
        occupied = TRY(make_zeros<std::uint8_t>(mask.samples().count(), context, what));
        if (has_unchosen) has_mesh = TRY(make_zeros<std::uint8_t>(mask.samples().count(), context, what));
        earlier = {occupied->values.data(), (has_mesh ? has_mesh : occupied)->values.data()};
      }
    }
    const auto label = static_cast<std::int64_t>(k) + 1;
    const bool is_chosen = chosen.add(label, name_of(path), mask.found);
    if (mask.found.voxels == 0) {
      masks.empty_.push_back(name_of(path));
      continue;
    }
    masks.faces_ += mask.found.faces;
    // A mask that shares voxels with every layer that has a bit gets a layer of its own.
    std::int64_t layer = std::countr_one(mask.found.layers);
    const bool has_bit = mask.found.layers != kLayerBits;
    if (!has_bit) layer = std::max(masks.count_, layer);
    masks.count_ = std::max(masks.count_, layer + 1);
    if (layer == 0) paint(mask, label, first);
    if (is_chosen) chosen.set_layer(name_of(path), layer);
    if (occupied && has_bit) {
      const auto bit = static_cast<std::uint8_t>(1U << layer);
      std::uint8_t* const bits = occupied->values.data();
      for_each_voxel(mask, [&](std::size_t at) { bits[at] |= bit; });
    }
    if (has_mesh && is_chosen) {
      std::uint8_t* const yes = has_mesh->values.data();
      for_each_voxel(mask, [&](std::size_t at) { yes[at] = 1; });
    }
    masks.names_.push_back({label, name_of(path), std::nullopt, layer});
    masks.figures_.push_back({label, mask.found.voxels, mask.found.box});
  }
  const std::string all = masks.paths_.size() > 1
                              ? fmt::format("{} and {} more", masks.grid_.source, masks.paths_.size() - 1)
                              : masks.grid_.source;
  chosen.tell(all, events);
  masks.grid_.source = all;
  masks.grid_.name = "masks";
  masks.grid_.grids = 0;
  masks.grid_.grid.clear();
  masks.first_ = std::make_shared<const Map>(std::move(first));
  return masks;
}

Result<field::ScalarField> MaskLayers::layer(std::int64_t number, const Context& context) const {
  std::shared_ptr<const Map> map = first_;
  if (number > 0) {
    Map made = TRY(make_map<Map>(grid_, paths_.size(), context));
    Events unheard;
    for (std::size_t k = 0; k < names_.size(); ++k) {
      if (names_[k].layer != number) continue;
      TRY(context.check());
      const std::string& path = paths_[static_cast<std::size_t>(names_[k].label) - 1];
      const Mask mask = TRY(read_mask(path, options_, &grid_, {}, context, unheard));
      if (mask.found.voxels != figures_[k].voxels || mask.found.box != figures_[k].box) {
        return fail(ErrorCode::input,
                    fmt::format("{}: the mask has changed since the program first read it", field_label(mask.field)),
                    "run again when no other program writes to the file");
      }
      paint(mask, names_[k].label, made);
    }
    map = std::make_shared<const Map>(std::move(made));
  }
  field::ScalarField field = grid_;
  field.labels = names_;
  field::DenseSamples samples;
  samples.type = map->type;
  samples.dims = std::get<field::DenseSamples>(grid_.samples).dims;
  samples.data = map->data;
  samples.owner = std::move(map);
  field.samples = std::move(samples);
  return field;
}

}  // namespace isoextract::convert
