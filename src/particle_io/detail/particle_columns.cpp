#include "particle_io/detail/particle_columns.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/checked.hpp"
#include "base/nearest_name.hpp"
#include "base/printable.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::size_t kMaxListedNames = 100;  // longest list of columns or attributes in a message

std::string column_list(const ParticleTable& table) {
  std::string list;
  for (std::size_t i = 0; i < table.columns.size() && i < kMaxListedNames; ++i) {
    list += fmt::format("{}{}", i == 0 ? "" : ", ", printable(table.columns[i].name, 80));
  }
  if (table.columns.size() > kMaxListedNames) list += ", ...";
  return list;
}

bool is_position(const ColumnTuple& group, const std::array<std::size_t, 3>& position) {
  return std::ranges::all_of(group.columns,
                             [&](std::size_t column) { return std::ranges::count(position, column) > 0; });
}

// Returns "the numeric attributes are density, velocity"; with words, "the attributes are density, species".
std::string attribute_list(const ParticleTable& table, const std::array<std::size_t, 3>& position,
                           bool with_words = false) {
  std::string list;
  std::size_t named = 0;
  for (const ColumnTuple& group : table.groups) {
    if (is_position(group, position) || (!with_words && !table.columns[group.columns.front()].numeric)) continue;
    if (++named > kMaxListedNames) return list + ", ...";
    list += fmt::format("{}{}", named == 1 ? with_words ? "the attributes are " : "the numeric attributes are " : ", ",
                        printable(group.name, 80));
  }
  return named > 0 ? list : with_words ? "the file has no attributes" : "the file has no numeric attributes";
}

std::vector<std::string> column_names(const ParticleTable& table) {
  std::vector<std::string> names;
  for (const ParticleColumn& column : table.columns) names.push_back(column.name);
  return names;
}

// Returns the names of the attributes, as find_attribute() takes them.
std::vector<std::string> attribute_names(const ParticleTable& table) {
  std::vector<std::string> names;
  for (const ColumnTuple& group : table.groups) names.push_back(group.name);
  return names;
}

std::optional<std::size_t> find_column(const ParticleTable& table, std::string_view name) {
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (table.columns[i].name == name) return i;
  }
  return std::nullopt;
}

// Finds a column by name, then by name ignoring case, then by number.
std::size_t named_column(const ParticleTable& table, const std::string& name) {
  if (const auto found = find_column(table, name)) return *found;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (to_lower(table.columns[i].name) == to_lower(name)) return i;
  }
  const bool digits = !name.empty() && name.size() < 9 && name.find_first_not_of("0123456789") == std::string::npos;
  const std::size_t number = digits ? std::stoul(name) : 0;
  if (number >= 1 && number <= table.columns.size()) return number - 1;
  throw InvalidParticleFile(
      fmt::format("there is no column '{}'{}", printable(name, 80), did_you_mean(name, column_names(table))),
      fmt::format("the file has {} columns: {}", table.columns.size(), column_list(table)));
}

// Case-sensitive: a group "p" of px, py and pz is a momentum.
constexpr std::string_view kHoudiniPosition = "P";

// Names of a position in order of preference.
constexpr std::array<std::string_view, 14> kPositionNames{
    "x y z",      "position", "positions", "pos",      "points", "point",  "coordinates",
    "coordinate", "coords",   "coord",     "location", "centre", "center", kHoudiniPosition};

bool is_called(std::string_view group, std::string_view position_name) {
  return position_name == kHoudiniPosition ? group == position_name : to_lower(group) == position_name;
}

bool is_position_name(std::string_view name) {
  return std::ranges::any_of(kPositionNames, [&](std::string_view known) { return is_called(name, known); });
}

std::array<std::size_t, 3> find_position(const ParticleTable& table, const ParticleReadOptions& options) {
  if (options.columns) {
    std::array<std::size_t, 3> position{};
    std::ranges::transform(*options.columns, position.begin(),
                           [&](const std::string& name) { return named_column(table, name); });
    return position;
  }
  if (table.position) return *table.position;
  for (const std::string_view name : kPositionNames) {
    for (const ColumnTuple& group : table.groups) {
      if (group.columns.size() != 3 || !is_called(group.name, name)) continue;
      return {group.columns[0], group.columns[1], group.columns[2]};
    }
  }
  std::array<std::size_t, 3> position{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_axis = [&](const ParticleColumn& column) {
      return to_lower(column.name) == std::string_view("xyz").substr(axis, 1);
    };
    const auto found = std::ranges::find_if(table.columns, is_axis);
    if (found == table.columns.end()) {
      throw InvalidParticleFile(
          fmt::format("expected columns x, y and z, found {} columns: {}", table.columns.size(), column_list(table)),
          {Remedy::give, Setting::columns});
    }
    position[axis] = static_cast<std::size_t>(found - table.columns.begin());
  }
  return position;
}

std::optional<ColumnTuple> find_attribute(const ParticleTable& table, const std::string& name) {
  for (const ColumnTuple& group : table.groups) {
    if (group.name == name) return group;
  }
  if (const auto column = find_column(table, name)) return ColumnTuple{name, {*column}};
  return std::nullopt;
}

// Throws if the attribute is not numeric.
void add_attribute(const ParticleTable& table, const ColumnTuple& attribute, ColumnChoice& choice) {
  check_numbers(table, attribute.columns, fmt::format("'{}'", printable(attribute.name, 80)),
                attribute_list(table, choice.position));
  if (std::ranges::count(choice.attributes, attribute.name, &ColumnTuple::name) > 0) return;
  choice.attributes.push_back(attribute);
}

// Returns whether an attribute that is not numeric can be read as words.
bool has_words(const ParticleTable& table, const ColumnTuple& attribute) {
  return table.has_words && attribute.columns.size() == 1 && table.columns[attribute.columns.front()].has_words;
}

// Chooses the attribute that a condition names: as words if it is text that can be read as words. Throws if any other
// attribute is not numeric.
void add_attribute_of_condition(const ParticleTable& table, const AttributeOfCondition& asked, ColumnChoice& choice) {
  for (const std::string& name : asked.names) {
    const auto attribute = find_attribute(table, name);
    if (!attribute) continue;
    const std::size_t column = attribute->columns.front();
    if (table.columns[column].numeric || !has_words(table, *attribute)) return add_attribute(table, *attribute, choice);
    std::erase_if(choice.words, [&](const WordColumn& words) { return words.name == attribute->name; });
    choice.words.push_back({attribute->name, column});
    return;
  }
  if (!asked.required) return;
  const std::string& name = asked.names.front();
  throw InvalidParticleFile(
      fmt::format("there is no attribute '{}'{}", printable(name, 80), did_you_mean(name, attribute_names(table))),
      fmt::format("{}; {}", attribute_list(table, choice.position, true), asked.mark));
}

// "x [mm]" -> "x " and "mm"; also "x (mm)".
struct BracketedSuffix {
  std::string_view before;
  std::string_view inside;
};
std::optional<BracketedSuffix> split_brackets(std::string_view header) {
  const char close = header.empty() ? ' ' : header.back();
  const std::size_t open = close == ']' ? header.rfind('[') : close == ')' ? header.rfind('(') : std::string_view::npos;
  if (open == std::string_view::npos || open == 0) return std::nullopt;
  return BracketedSuffix{header.substr(0, open), header.substr(open + 1, header.size() - open - 2)};
}

std::string_view without_spaces_behind(std::string_view text) {
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Suffixes of components: digits or these letters. Colors only in brackets or after a separator: "Cd[r]", "Cd.r".
enum class ComponentNames { digits, axes, colors };
constexpr std::string_view kAxes = "xyz";
constexpr std::string_view kColors = "rgba";

// "vx" -> "v" and 0; "Points:2" -> "Points" and 2; "v[y]" -> "v" and 1. The stem is empty for x, y and z alone.
struct Component {
  std::string_view stem;
  std::size_t index;
  ComponentNames names;
};
std::optional<Component> component_of(std::string_view name) {
  constexpr std::string_view kBetween = ":_.- ";
  if (name.empty()) return std::nullopt;
  const auto brackets = split_brackets(name);
  std::string_view stem = name.substr(0, name.size() - 1);
  char last = name.back();
  bool is_apart = brackets.has_value();
  if (brackets) {
    if (brackets->inside.size() != 1) return std::nullopt;
    stem = without_spaces_behind(brackets->before);
    last = brackets->inside.front();
  } else if (!stem.empty() && kBetween.find(stem.back()) != std::string_view::npos) {
    stem.remove_suffix(1);
    is_apart = !stem.empty();
  }
  const std::string letter = to_lower({&last, 1});
  if (const std::size_t axis = kAxes.find(letter); axis != std::string_view::npos) {
    return Component{stem, axis, ComponentNames::axes};
  }
  if (const std::size_t channel = kColors.find(letter); is_apart && channel != std::string_view::npos) {
    return Component{stem, channel, ComponentNames::colors};
  }
  if (is_digit(last) && !stem.empty()) {
    return Component{stem, static_cast<std::size_t>(last - '0'), ComponentNames::digits};
  }
  return std::nullopt;
}

// Returns the number of components of the quantity that starts with column `first`; 1 if it is not part of a tuple.
// `name_of` returns a column's name, empty after the last.
template <class NameOf>
std::size_t count_components(std::size_t first, const NameOf& name_of) {
  const auto start = component_of(name_of(first));
  if (!start || start->index != 0) return 1;
  const std::size_t most = start->names == ComponentNames::digits ? 10 : kColors.size();
  std::size_t count = 1;
  while (count < most) {
    const auto next = component_of(name_of(first + count));
    if (!next || next->stem != start->stem || next->index != count || next->names != start->names) break;
    ++count;
  }
  return count >= 3 || start->names == ComponentNames::digits ? count : 1;
}

}  // namespace

void add_tuple(ParticleTable& table, const std::string& name, const std::string& type, std::size_t components,
               bool numeric, std::optional<AttributeKind> kind) {
  ColumnTuple group{name, {}, kind};
  for (std::size_t i = 0; i < components; ++i) {
    group.columns.push_back(table.columns.size());
    table.columns.push_back({components == 1 ? name : fmt::format("{}:{}", name, i), {}, type, numeric});
  }
  if (components > 0) table.groups.push_back(std::move(group));
}

void group_by_names(ParticleTable& table) {
  const std::vector<ParticleColumn>& columns = table.columns;
  for (std::size_t first = 0; first < columns.size();) {
    // Columns of a position stay together, so that the error names the one that is not numeric.
    const auto start = component_of(columns[first].name);
    const bool is_whole = start && is_position_name(start->stem);
    const std::size_t count = count_components(first, [&](std::size_t column) -> std::string_view {
      if (column >= columns.size() || (!is_whole && columns[column].numeric != columns[first].numeric)) return {};
      return columns[column].name;
    });
    ColumnTuple group{columns[first].name, {}};
    if (count > 1) {
      const std::string_view stem = component_of(columns[first].name)->stem;
      group.name = stem.empty() ? "x y z" : std::string(stem);
    }
    for (std::size_t i = 0; i < count; ++i) group.columns.push_back(first + i);
    table.groups.push_back(std::move(group));
    first += count;
  }
  make_group_names_unique(table);
}

void make_group_names_unique(ParticleTable& table) {
  std::unordered_set<std::string> taken;
  std::unordered_map<std::string, std::size_t> repeats;
  for (ColumnTuple& group : table.groups) {
    const std::string name = group.name;
    while (!taken.insert(group.name).second) group.name = fmt::format("{}[{}]", name, ++repeats[name]);
  }
}

std::vector<NameAndUnit> split_units(std::span<const std::string_view> headers) {
  std::vector<NameAndUnit> split;
  std::size_t components = 0;  // remaining components of the current tuple
  for (std::size_t i = 0; i < headers.size(); ++i) {
    if (components == 0) {
      const std::size_t count = count_components(
          i, [&](std::size_t column) { return column < headers.size() ? headers[column] : std::string_view(); });
      if (count > 1) components = count;
    }
    const bool is_component = components > 0;
    if (is_component) --components;
    const auto brackets = split_brackets(headers[i]);
    // A number or an axis in brackets counts components and is not a unit.
    if (is_component || !brackets || brackets->inside.find_first_not_of("0123456789") == std::string_view::npos ||
        (brackets->inside.size() == 1 && kAxes.find(to_lower(brackets->inside)) != std::string_view::npos)) {
      split.push_back({std::string(headers[i]), {}});
    } else {
      split.push_back({std::string(without_spaces_behind(brackets->before)), std::string(brackets->inside)});
    }
  }
  return split;
}

void check_numbers(const ParticleTable& table, std::span<const std::size_t> wanted, std::string_view what,
                   const Hint& hint) {
  for (const std::size_t column : wanted) {
    if (table.columns[column].numeric) continue;
    throw InvalidParticleFile(fmt::format("expected numbers for {}, found {} in the column '{}'", what,
                                          table.columns[column].type, printable(table.columns[column].name, 80)),
                              hint);
  }
}

ColumnChoice choose_columns(const ParticleTable& table, const ParticleReadOptions& options) {
  ColumnChoice choice;
  choice.position = find_position(table, options);
  const auto& [x, y, z] = choice.position;
  const auto& columns = table.columns;
  if (columns[x].unit == columns[y].unit && columns[y].unit == columns[z].unit) choice.length_unit = columns[x].unit;
  if (options.all_attributes) {
    for (const ColumnTuple& group : table.groups) {
      if (is_position(group, choice.position)) continue;
      if (columns[group.columns.front()].numeric) {
        choice.attributes.push_back(group);
      } else if (has_words(table, group)) {
        choice.words.push_back({group.name, group.columns.front(), false});
      } else {
        choice.notes.push_back({NoteId::data_left_out,
                                fmt::format("the reader skips '{}', which has no numbers", printable(group.name, 80))});
      }
    }
  }
  for (const std::string& name : options.attributes) {
    const auto attribute = find_attribute(table, name);
    if (!attribute) {
      throw InvalidParticleFile(
          fmt::format("there is no attribute '{}'{}", printable(name, 80), did_you_mean(name, attribute_names(table))),
          attribute_list(table, choice.position));
    }
    add_attribute(table, *attribute, choice);
  }
  for (const std::string& name : options.optional_attributes) {
    if (const auto attribute = find_attribute(table, name)) add_attribute(table, *attribute, choice);
  }
  for (const std::string& name : options.first_scalar_of) {
    const auto found = std::ranges::find(table.groups, name, &ColumnTuple::name);
    if (found == table.groups.end() || found->columns.size() != 1 || !columns[found->columns.front()].numeric ||
        is_position(*found, choice.position)) {
      continue;
    }
    if (std::ranges::count(choice.attributes, name, &ColumnTuple::name) == 0) choice.attributes.push_back(*found);
    break;
  }
  for (const AttributeOfCondition& asked : options.condition) add_attribute_of_condition(table, asked, choice);
  return choice;
}

void describe_table(const ParticleTable& table, const ParticleReadOptions& options, ParticleInfo& info) {
  std::optional<ColumnChoice> choice;
  try {
    ParticleReadOptions positions;
    positions.columns = options.columns;
    choice = choose_columns(table, positions);
    info.length_unit = choice->length_unit;
  } catch (const InvalidParticleFile& why) {
    if (options.columns) throw;
    info.notes.push_back({NoteId::unclear_positions, why.what()});
  }
  for (const ColumnTuple& group : table.groups) {
    if (choice && is_position(group, choice->position)) continue;
    const ParticleColumn& first = table.columns[group.columns.front()];
    info.quantities.push_back({group.name, first.type, first.unit, group.columns.size(), first.numeric});
  }
}

points::ParticleSet make_particles(const Context& context, const std::string& label, std::uint64_t count,
                                   const ColumnChoice& choice) {
  const auto numbers =
      std::accumulate(choice.attributes.begin(), choice.attributes.end(), std::uint64_t{0},
                      [](std::uint64_t sum, const ColumnTuple& group) { return sum + group.columns.size(); });
  const auto bytes = checked_product(
      count, sizeof(glm::dvec3) + numbers * sizeof(float) + choice.words.size() * sizeof(std::uint32_t));
  points::ParticleSet set;
  set.memory = must(context.reserve(bytes.value_or(~std::uint64_t{0}), fmt::format("{}: {} particles", label, count)));
  set.label = label;
  set.positions = Buffer<glm::dvec3>(count);
  for (const ColumnTuple& group : choice.attributes) {
    set.attributes.push_back(
        {group.name, group.columns.size(), Buffer<float>(count * group.columns.size()), group.kind});
  }
  for (const WordColumn& words : choice.words) set.words.push_back({words.name, {}, Buffer<std::uint32_t>(count)});
  return set;
}

void set_box(const points::SimulationBox& box, bool in_axis_order, ParticleFile& file) {
  if (box.is_valid() && in_axis_order) {
    file.particles.box = box;
  } else if (box.is_periodic() && !in_axis_order) {
    file.notes.push_back(
        {NoteId::box_ignored,
         "the reader ignores the periodic box of the file, because the chosen columns are not its x, y "
         "and z in this order"});
  } else if (box.is_periodic()) {
    file.notes.push_back({NoteId::box_ignored,
                          "the reader ignores the periodic box of the file: it has no volume, or an "
                          "edge that is not finite"});
  }
}

void throw_particle_error(std::size_t particle, std::size_t particles) {
  throw InvalidParticleFile(
      fmt::format("expected {} particles, found values of a further one (particle {})", particles, particle + 1));
}

std::vector<ColumnSink> sinks_of(points::ParticleSet& set, const ColumnChoice& choice) {
  std::vector<ColumnSink> sinks;
  if (set.size() == 0) return sinks;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sinks.push_back(
        {choice.position[axis], &set.positions[0][static_cast<glm::length_t>(axis)], nullptr, 3, set.size()});
  }
  for (std::size_t a = 0; a < choice.attributes.size(); ++a) {
    const std::vector<std::size_t>& columns = choice.attributes[a].columns;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      sinks.push_back({columns[c], nullptr, set.attributes[a].values.data() + c, columns.size(), set.size()});
    }
  }
  for (std::size_t w = 0; w < choice.words.size(); ++w) {
    ColumnSink sink{.column = choice.words[w].column, .particles = set.size()};
    sink.words = std::make_shared<WordIndexer>(set.words[w], choice.words[w].wanted);
    sinks.push_back(std::move(sink));
  }
  std::ranges::stable_sort(sinks, {}, &ColumnSink::column);
  return sinks;
}

void deliver_records(const RecordLayout& layout, std::span<const std::byte> records, std::size_t first,
                     std::span<const ColumnSink> sinks) {
  const std::size_t count = records.size() / layout.bytes;
  for (const ColumnSink& sink : sinks) {
    const RecordLayout::Field& field = layout.fields[sink.column];
    if (!field.type) {
      throw InvalidParticleFile(fmt::format("expected a number in column {}, found another type", sink.column + 1));
    }
    if (field.offset + number_size(*field.type) > layout.bytes) {
      throw InvalidParticleFile(
          fmt::format("expected column {} inside the record of {} bytes, found it at bytes {} to {}", sink.column + 1,
                      layout.bytes, field.offset, field.offset + number_size(*field.type)));
    }
    for_each_number(*field.type, field.endian, records.data() + field.offset, layout.bytes, count,
                    [&](std::size_t i, double value) { sink.put(first + i, value); });
  }
}

void read_records(ContentReader& content, const RecordLayout& layout, std::uint64_t count,
                  std::span<const ColumnSink> sinks) {
  for (std::uint64_t done = 0; done < count;) {
    const auto bytes = content.peek(layout.bytes);
    const std::uint64_t at_hand = std::min<std::uint64_t>(count - done, bytes.size() / layout.bytes);
    if (at_hand == 0) {
      throw InvalidParticleFile(
          fmt::format("expected {} particles of {} bytes, found {} before the end of the file at byte {}", count,
                      layout.bytes, done, content.position() + bytes.size()));
    }
    const std::size_t whole = static_cast<std::size_t>(at_hand) * layout.bytes;
    deliver_records(layout, bytes.first(whole), static_cast<std::size_t>(done), sinks);
    content.advance(whole);
    done += at_hand;
  }
}

}  // namespace isoextract::particle_io
