#include "zarr_hierarchy.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace isoextract_zarr {
namespace {

constexpr std::uint64_t kMostMetadata = std::uint64_t{64} << 20;

// Replaces NaN and Infinity, which Python writes into attributes although JSON has no such words, by null.
std::string without_nan(std::string_view text) {
  std::string result;
  bool is_string = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (is_string && c == '\\' && at + 1 < text.size()) {
      result += c;
      result += text[++at];
      continue;
    }
    if (c == '"') is_string = !is_string;
    bool is_replaced = false;
    for (const std::string_view word :
         {std::string_view("NaN"), std::string_view("-Infinity"), std::string_view("Infinity")}) {
      if (is_string || !text.substr(at).starts_with(word)) continue;
      result += "null";
      at += word.size() - 1;
      is_replaced = true;
      break;
    }
    if (!is_replaced) result += c;
  }
  return result;
}

// Throws if values are nested too deeply: copying and printing JSON recurses.
Json parse_text(std::string_view text, const std::string& key) {
  constexpr int kDeepest = 64;
  const auto check_depth = [&](int depth, Json::parse_event_t /*event*/, Json& /*value*/) {
    if (depth <= kDeepest) return true;
    throw ReadError(
        fmt::format("expected values nested at most {} deep in '{}', found deeper ones", kDeepest, shown(key)));
  };
  return Json::parse(text, check_depth, false);
}

Json parse_json(std::string_view text, const std::string& key) {
  Json parsed = parse_text(text, key);
  if (parsed.is_discarded()) parsed = parse_text(without_nan(text), key);
  if (!parsed.is_object()) throw ReadError(fmt::format("expected a JSON object in '{}', found other text", shown(key)));
  return parsed;
}

// Returns the path of the node that a metadata key belongs to.
std::string_view parent_of(std::string_view key) {
  const std::size_t slash = key.rfind('/');
  return slash == std::string_view::npos ? std::string_view() : key.substr(0, slash);
}

}  // namespace

Hierarchy::Hierarchy(const Store& store, const isoextract_plugin_host& host)
    : store_(store), host_(host), memory_(host) {
  read_consolidated();
}

void Hierarchy::read_consolidated() {
  if (const auto v2 = read_json(".zmetadata")) {
    const Json& entries = member(*v2, "metadata");
    if (entries.is_object()) {
      for (const auto& entry : entries.items()) consolidated_[entry.key()] = entry.value();
    }
  }
  if (const auto v3 = read_json("zarr.json")) {
    const Json& entries = member(member(*v3, "consolidated_metadata"), "metadata");
    if (!entries.is_object()) return;
    for (const auto& entry : entries.items()) consolidated_[join(entry.key(), "zarr.json")] = entry.value();
  }
}

std::optional<Json> Hierarchy::read_json(const std::string& key) {
  const std::unique_ptr<Value> value = store_.find(key);
  if (value == nullptr) {
    const auto found = consolidated_.find(key);
    if (found == consolidated_.end() || !found->second.is_object()) return std::nullopt;
    return found->second;
  }
  if (value->size() > kMostMetadata) {
    throw ReadError(fmt::format("expected at most {} bytes of metadata in '{}', found {}", kMostMetadata, shown(key),
                                value->size()));
  }
  // A parsed value takes several times its text.
  constexpr std::uint64_t kParsed = 8;
  memory_.take(kParsed * value->size());
  std::string text(value->size(), '\0');
  value->read(0, std::as_writable_bytes(std::span(text)));
  if (std::string file = store_.file_of(key); !file.empty()) files_.insert(std::move(file));
  return parse_json(text, key);
}

std::optional<Node> Hierarchy::find(const std::string& path) {
  Node node;
  if (auto v3 = read_json(join(path, "zarr.json"))) {
    if (member(*v3, "zarr_format") != 3) {
      throw ReadError(fmt::format("expected zarr_format 3 in '{}'", shown(join(path, "zarr.json"))));
    }
    node.zarr_format = 3;
    node.is_array = member(*v3, "node_type") == "array";
    if (!node.is_array && member(*v3, "node_type") != "group") {
      throw ReadError(fmt::format("expected the node_type array or group in '{}'", shown(join(path, "zarr.json"))));
    }
    node.attributes = member(*v3, "attributes");
    node.metadata = std::move(*v3);
    return node;
  }
  if (auto array = read_json(join(path, ".zarray"))) {
    node.is_array = true;
    node.metadata = std::move(*array);
  } else if (auto group = read_json(join(path, ".zgroup"))) {
    node.metadata = std::move(*group);
  } else {
    return std::nullopt;
  }
  if (auto attributes = read_json(join(path, ".zattrs"))) node.attributes = std::move(*attributes);
  return node;
}

ArrayMetadata parse_array(const Node& node) {
  return node.zarr_format == 3 ? parse_v3_array(node.metadata) : parse_v2_array(node.metadata, node.attributes);
}

ArrayMetadata Hierarchy::array(const std::string& path) {
  const auto node = find(path);
  if (!node || !node->is_array) throw ReadError(fmt::format("expected an array at '{}', found none", shown(path)));
  try {
    return parse_array(*node);
  } catch (const ReadError& error) {
    throw ReadError(fmt::format("array '{}': {}", shown(path), error.what()));
  }
}

std::vector<std::string> Hierarchy::children(const std::string& group) const {
  std::vector<std::string> names = store_.folders(group);
  for (const auto& [key, value] : consolidated_) {
    const std::string_view path = parent_of(key);
    if (path.empty() || parent_of(path) != group) continue;
    names.emplace_back(group.empty() ? path : path.substr(group.size() + 1));
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace isoextract_zarr
