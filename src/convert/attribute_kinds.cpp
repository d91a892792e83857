#include "convert/attribute_kinds.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "convert/json_values.hpp"
#include "mesh/attribute_map.hpp"

namespace isoextract::convert {
namespace {

constexpr const char* kEntry = "attributes";  // the key in a placement record

// Writers replace characters that their format does not allow in names, so names are compared in this form.
std::string plain_name(std::string_view name) {
  std::string plain(name);
  std::ranges::replace_if(
      plain, [](char c) { return !is_letter(c) && !is_digit(c); }, '_');
  return plain;
}

// Returns the kinds in the placement record of a file that isoextract wrote.
std::vector<NamedKind> kinds_in(std::string_view placement) {
  std::vector<NamedKind> kinds;
  const Json json = Json::parse(placement, nullptr, false);
  if (!json.is_object() || !json.contains(kEntry) || !json[kEntry].is_object()) return kinds;
  for (const auto& [name, word] : json[kEntry].items()) {
    const auto kind = word.is_string() ? value_of<AttributeKind>(word.get<std::string>()) : std::nullopt;
    if (kind) kinds.push_back({name, *kind});
  }
  return kinds;
}

}  // namespace

Result<std::optional<AttributeKind>> find_kind(const AttributeChoice& choice, std::size_t components,
                                               std::optional<AttributeKind> stated) {
  if (choice.kind && is_transformed_with_mesh(*choice.kind) && components != 3) {
    return fail(ErrorCode::usage,
                fmt::format("the attribute '{}': expected three components of a {}, found {}", printable(choice.name),
                            word_of(*choice.kind), components),
                fmt::format("leave out ':{}', the kind of the attribute", word_of(*choice.kind)));
  }
  if (choice.kind) return choice.kind;
  if (components < 3) return AttributeKind::scalar;
  auto kind = stated ? stated : kind_by_name(choice.name);
  if (!kind) {
    std::string_view from = choice.from;  // "fire.vdb[velocity]"
    const std::size_t open = from.rfind('[');
    if (from.ends_with(']') && open != std::string_view::npos) from = from.substr(open + 1, from.size() - open - 2);
    kind = kind_by_name(from);
  }
  if (kind && is_transformed_with_mesh(*kind) && components != 3) return AttributeKind::scalar;
  return kind;
}

std::string kinds_text(const std::vector<NamedKind>& kinds) {
  // Built as text, not as a JSON document, like the rest of a placement record (placement_record.cpp says why).
  std::string text;
  for (const NamedKind& named : kinds) {
    if (!is_transformed_with_mesh(named.kind)) continue;
    text += fmt::format(R"({}"{}":"{}")", text.empty() ? "{" : ",", plain_name(named.name), word_of(named.kind));
  }
  return text.empty() ? text : text + "}";
}

std::vector<NamedKind> kinds_of(const mesh::Mesh& mesh, bool is_by_isoextract, std::string_view placement) {
  const std::vector<NamedKind> stated = kinds_in(placement);
  std::vector<NamedKind> kinds;
  for (const mesh::Attribute& attribute : mesh.attributes) {
    const auto found = std::ranges::find(stated, plain_name(attribute.name), &NamedKind::name);
    const auto kind = !is_by_isoextract       ? kind_by_name(attribute.name)
                      : found != stated.end() ? std::optional(found->kind)
                                              : std::nullopt;
    if (kind && mesh::is_transformed_with_mesh(attribute, *kind)) kinds.push_back({attribute.name, *kind});
  }
  return kinds;
}

void transform_attributes(mesh::Mesh& mesh, const std::vector<NamedKind>& kinds, const field::Affine& map) {
  for (mesh::Attribute& attribute : mesh.attributes) {
    const auto found = std::ranges::find(kinds, attribute.name, &NamedKind::name);
    if (found == kinds.end() || attribute.role != mesh::AttributeRole::other) continue;
    // Normals are renormalized even without a move: interpolated normals are shorter than 1.
    if (map == field::Affine() && found->kind != AttributeKind::normal) continue;
    map_attribute(attribute, found->kind, map.linear, map.offset);
  }
}

}  // namespace isoextract::convert
