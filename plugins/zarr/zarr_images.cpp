#include "zarr_images.hpp"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace isoextract_zarr {
namespace {

constexpr int kDeepest = 16;  // groups within groups
constexpr std::size_t kMostNodes = 10000;

// Walks the groups of a hierarchy in the order of their names.
class Finder {
 public:
  Finder(Hierarchy& hierarchy, std::uint64_t level) : hierarchy_(hierarchy), level_(level) {}

  Images find() {
    const auto root = hierarchy_.find("");
    if (!root) throw ReadError("expected a Zarr hierarchy with a zarr.json, .zarray or .zgroup at its root");
    found_.format = fmt::format("Zarr v{}", root->zarr_format);
    visit("", *root, 0);
    if (found_.images.empty()) {
      if (!first_problem_.empty()) throw ReadError(first_problem_);
      throw ReadError(found_.notes.empty() ? "expected arrays with two or more axes, found none"
                                           : found_.notes.front());
    }
    if (level_ > 0 && !has_pyramid_) {
      throw ReadError(fmt::format("expected level 0, as there is no OME-Zarr pyramid, found level {}", level_));
    }
    for (const auto& [text, count] : left_out_) {
      found_.notes.push_back(count.first == 1
                                 ? fmt::format("the reader leaves out '{}': {}", count.second, text)
                                 : fmt::format("the reader leaves out {} arrays and images such as '{}': {}",
                                               count.first, count.second, text));
    }
    return std::move(found_);
  }

 private:
  void visit(const std::string& path, const Node& node, int depth) {
    if (node.is_array) return add_array(path, node);
    if (member(ome_of(node), "multiscales").is_array()) {
      has_pyramid_ = true;
      try {
        found_.images.push_back(read_multiscales(hierarchy_, path, node, level_, found_));
      } catch (const ReadError& error) {
        leave_out(path, error.what());
      }
      // The other children are the levels of this image.
      visit_child(path, "labels", depth);
      return;
    }
    for (const std::string& child : hierarchy_.children(path)) visit_child(path, child, depth);
  }

  void visit_child(const std::string& group, const std::string& name, int depth) {
    const std::string path = join(group, name);
    if (++nodes_ > kMostNodes || depth == kDeepest) {
      if (!std::exchange(is_cut_, true)) {
        found_.notes.push_back(
            fmt::format("the reader leaves out groups below '{}': the hierarchy has more than {} groups and "
                        "arrays, or groups nested more than {} deep",
                        shown(group), kMostNodes, kDeepest));
      }
      return;
    }
    try {
      const auto node = hierarchy_.find(checked_path(path));
      if (!node) return;
      // A symbolic link may lead back to a group above.
      if (!seen_.insert(hierarchy_.store().identity(path)).second) return;
      visit(path, *node, depth + 1);
    } catch (const ReadError& error) {
      leave_out(path, error.what());
    }
  }

  void add_array(const std::string& path, const Node& node) {
    Array array;
    array.path = path;
    try {
      array.metadata = parse_array(node);
    } catch (const ReadError& error) {
      return leave_out(path, error.what());
    }
    const std::vector<std::uint64_t>& shape = array.metadata.shape;
    if (shape.size() < 2) return;  // coordinates and other lists
    if (std::ranges::find(shape, 0U) != shape.end()) return leave_out(path, "it is empty");
    found_.images.push_back(describe_plain_array(hierarchy_, std::move(array), node.attributes, found_));
  }

  void leave_out(const std::string& path, const std::string& why) {
    if (first_problem_.empty()) first_problem_ = path.empty() ? why : fmt::format("'{}': {}", shown(path), why);
    auto& [count, example] = left_out_[why];
    if (count++ == 0) example = shown(path);
  }

  Hierarchy& hierarchy_;
  std::uint64_t level_;
  Images found_;
  std::size_t nodes_ = 0;
  bool has_pyramid_ = false;
  bool is_cut_ = false;
  std::set<std::string> seen_;
  std::string first_problem_;
  std::map<std::string, std::pair<std::size_t, std::string>> left_out_;
};

}  // namespace

int Image::axis_of(Axis::Kind kind) const {
  const auto found = std::ranges::find(axes, kind, &Axis::kind);
  return found == axes.end() ? kNoAxis : static_cast<int>(found - axes.begin());
}

std::uint64_t Image::length_of(Axis::Kind kind) const {
  const int axis = axis_of(kind);
  return axis == kNoAxis ? 1 : array.metadata.shape[static_cast<std::size_t>(axis)];
}

Images find_images(Hierarchy& hierarchy, std::uint64_t level) { return Finder(hierarchy, level).find(); }

Axis::Kind kind_called(const std::string& name) {
  std::string word = name;
  std::ranges::transform(word, word.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  const auto is_one_of = [&](std::initializer_list<std::string_view> words) {
    return std::ranges::find(words, word) != words.end();
  };
  if (is_one_of({"x", "lon", "longitude"})) return Axis::Kind::x;
  if (is_one_of({"y", "lat", "latitude"})) return Axis::Kind::y;
  if (is_one_of({"z", "depth", "lev", "level", "height", "altitude"})) return Axis::Kind::z;
  if (is_one_of({"t", "time"})) return Axis::Kind::time;
  if (is_one_of({"c", "channel", "band"})) return Axis::Kind::channel;
  return Axis::Kind::other;
}

void set_kinds_by_position(std::vector<Axis>& axes) {
  using enum Axis::Kind;
  std::vector<Axis::Kind> open;
  const auto is_used = [&](Axis::Kind kind) { return std::ranges::find(axes, kind, &Axis::kind) != axes.end(); };
  for (const Axis::Kind kind : {x, y, z, axes.size() == 4 ? time : channel, axes.size() == 4 ? channel : time}) {
    if (!is_used(kind)) open.push_back(kind);
  }
  std::size_t next = 0;
  for (std::size_t axis = axes.size(); axis-- > 0 && next < open.size();) {
    if (axes[axis].kind == other && axes[axis].name.empty()) axes[axis].kind = open[next++];
  }
}

}  // namespace isoextract_zarr
