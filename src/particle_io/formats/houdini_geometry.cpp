// An attribute is [definition, values]. Its numbers are stored in one of three forms: "tuples", "arrays" of one
// component each, or "rawpagedata". The last form stores pages of elements; each page has one block per sub-vector of
// components ("packing"). A block is a single tuple if "constantpageflags" marks it as constant.
#include "particle_io/formats/houdini_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "particle_io/formats/houdini_json.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::uint64_t kMostComponents = 1024;
constexpr std::uint64_t kMaxPageElements = 65536;  // elements; Houdini uses 1024
constexpr std::size_t kMostNamesOfMap = 256;

// Calls use(name, first token of the value) for each pair of an array or a map; use() must consume the value. Rejects
// repeated names, as a second "pointcount" would apply to only some of the attributes.
template <class F>
void each_pair(HoudiniJson& json, const JsonToken& first, F&& use) {
  if (first.kind != JsonToken::Kind::begin) json.expected("an array of names and values");
  std::unordered_set<std::string> names;
  while (true) {
    const JsonToken name = json.next();
    if (name.kind == JsonToken::Kind::end) return;
    if (name.kind != JsonToken::Kind::text) json.expected("a name");
    if (names.size() == kMostNamesOfMap) json.expected(fmt::format("at most {} names in a map", kMostNamesOfMap));
    if (!names.insert(name.text).second) {
      throw InvalidParticleFile(fmt::format("expected each key of a JSON map once, found '{}' again before byte {}",
                                            printable(name.text, 80), json.content().position()));
    }
    const JsonToken value = json.next();
    if (value.kind == JsonToken::Kind::end) json.expected("a value after a name");
    use(name.text, value);
  }
}

std::uint64_t whole_of(HoudiniJson& json, const JsonToken& token, std::string_view what, std::uint64_t most) {
  const bool fits = token.kind == JsonToken::Kind::number && token.number >= 0 &&
                    token.number <= static_cast<double>(most) && token.number == std::floor(token.number);
  if (!fits) json.expected(fmt::format("{}, a whole number from 0 to {},", what, most));
  return static_cast<std::uint64_t>(token.number);
}

// The texts of a string attribute; its numbers are indices into these texts.
struct HoudiniTexts {
  std::vector<std::string> texts;
  std::size_t bytes = 0;
  bool too_many = false;  // beyond the limits of WordIndexer; `texts` is then empty

  void add(std::string_view text) {
    if (too_many) return;
    bytes += text.size();
    texts.emplace_back(text);
    too_many = texts.size() > kMaxDistinctWords || bytes > kMaxWordBytes;
    if (too_many) texts = {};
  }
};

// Delivers the numbers of an attribute in the order in which they arrive, or its words.
class AttributeSinks {
 public:
  AttributeSinks(std::uint64_t points, std::uint64_t size, std::span<const ColumnSink> sinks, std::size_t first_column,
                 const HoudiniTexts& texts)
      : points_(points), components_(static_cast<std::size_t>(size)), texts_(texts) {
    for (const ColumnSink& sink : sinks) {
      if (sink.column >= first_column && sink.column - first_column < components_.size()) {
        components_[sink.column - first_column].push_back(sink);
      }
    }
  }

  [[nodiscard]] std::uint64_t points() const { return points_; }
  [[nodiscard]] std::uint64_t size() const { return components_.size(); }

  void put(std::uint64_t point, std::uint64_t count, std::size_t component, double value) const {
    for (const ColumnSink& sink : components_[component]) {
      for (std::uint64_t i = 0; i < count; ++i) {
        if (sink.words) {
          put_word(sink, static_cast<std::size_t>(point + i), value);
        } else {
          sink.put(static_cast<std::size_t>(point + i), value);
        }
      }
    }
  }

 private:
  // An index of -1 means no text.
  void put_word(const ColumnSink& sink, std::size_t point, double index) const {
    if (texts_.too_many) return sink.words->give_up();
    if (index == -1) return sink.put_word(point, {});
    if (!(index >= 0 && index < static_cast<double>(texts_.texts.size()))) {
      throw InvalidParticleFile(
          fmt::format("expected a text index below {}, or -1 for none, found {}", texts_.texts.size(), index));
    }
    sink.put_word(point, texts_.texts[static_cast<std::size_t>(index)]);
  }

  std::uint64_t points_;
  std::vector<std::vector<ColumnSink>> components_;
  const HoudiniTexts& texts_;
};

// Tracks the position within an attribute's pages while its numbers arrive.
class PageCursor {
 public:
  PageCursor(const AttributeSinks& sinks, std::uint64_t page, std::vector<std::uint64_t> packing,
             const std::vector<std::vector<bool>>& constant)
      : sinks_(sinks), page_(page), packing_(std::move(packing)), constant_(constant) {}

  // Returns false if there are too many numbers.
  bool take(double value) {
    if (done()) return false;
    const std::uint64_t in_page = std::min(page_, sinks_.points() - first_);
    const bool same = part_ < constant_.size() && page_number_ < constant_[part_].size() &&
                      constant_[part_][static_cast<std::size_t>(page_number_)];
    sinks_.put(first_ + element_, same ? in_page : 1, static_cast<std::size_t>(before_ + component_), value);
    if (++component_ < packing_[part_]) return true;
    component_ = 0;
    if (!same && ++element_ < in_page) return true;
    element_ = 0;
    before_ += packing_[part_];
    if (++part_ < packing_.size()) return true;
    part_ = 0;
    before_ = 0;
    first_ += in_page;
    ++page_number_;
    return true;
  }
  [[nodiscard]] bool done() const { return first_ == sinks_.points(); }

 private:
  const AttributeSinks& sinks_;
  std::uint64_t page_;
  std::vector<std::uint64_t> packing_;  // number of components of each sub-vector
  const std::vector<std::vector<bool>>& constant_;
  std::uint64_t first_ = 0;  // first element of the page
  std::uint64_t page_number_ = 0;
  std::size_t part_ = 0;         // index of the sub-vector
  std::uint64_t before_ = 0;     // components of the earlier sub-vectors
  std::uint64_t element_ = 0;    // within the page
  std::uint64_t component_ = 0;  // within the sub-vector
};

// The layout of the pages, read before their data.
struct Paging {
  std::uint64_t page = 0;
  std::vector<std::uint64_t> packing;
  std::vector<std::vector<bool>> constant;  // per sub-vector and page
  std::vector<Reservation> memory;          // for the flags of each sub-vector
};

// A compressed file can contain any number of flags, so memory is reserved for them.
void read_constant_flags(HoudiniJson& json, const JsonToken& first, std::uint64_t points, Paging& paging) {
  if (first.kind != JsonToken::Kind::begin) json.expected("an array of flags of pages");
  const std::uint64_t pages = paging.page == 0 ? points : (points + paging.page - 1) / paging.page;
  while (true) {
    const JsonToken flags = json.next();
    if (flags.kind == JsonToken::Kind::end) return;
    if (paging.constant.size() == kMostComponents) json.expected("fewer sub-vectors");
    std::vector<bool>& of_part = paging.constant.emplace_back();
    json.each_number(flags, [&](double value) {
      if (of_part.size() == pages) json.expected("one flag per page");
      if (of_part.empty()) {
        paging.memory.push_back(json.content().reserve((pages + 63) / 64 * 8, "flags of pages"));
        of_part.reserve(static_cast<std::size_t>(pages));
      }
      of_part.push_back(value != 0);
    });
  }
}

void read_pages(HoudiniJson& json, const JsonToken& first, Paging& paging, const AttributeSinks& sinks) {
  if (paging.page == 0) json.expected("the size of pages before their data");
  if (paging.packing.empty()) paging.packing = {sinks.size()};
  std::uint64_t components = 0;
  for (const std::uint64_t part : paging.packing) components += part;
  const bool has_empty = std::ranges::count(paging.packing, 0U) > 0;
  if (components != sinks.size() || has_empty) json.expected("sub-vectors of all components of an attribute");
  PageCursor walk(sinks, paging.page, std::move(paging.packing), paging.constant);
  json.each_number(first, [&](double value) {
    if (!walk.take(value)) json.expected("no more data of pages");
  });
  if (!walk.done()) json.expected("more data of pages");
}

// Reads numbers without constant pages: element by element, or component by component.
void read_all_numbers(HoudiniJson& json, const JsonToken& first, bool by_component, const AttributeSinks& sinks) {
  std::uint64_t taken = 0;
  const std::uint64_t all = checked_product(sinks.points(), sinks.size()).value_or(0);
  json.each_number(first, [&](double value) {
    if (taken == all) json.expected("the end of an attribute's numbers");
    const std::uint64_t point = by_component ? taken % sinks.points() : taken / sinks.size();
    const std::uint64_t component = by_component ? taken / sinks.points() : taken % sinks.size();
    sinks.put(point, 1, static_cast<std::size_t>(component), value);
    ++taken;
  });
  if (taken != all) json.expected("more numbers of an attribute");
}

// Reads the value of "values".
void read_attribute_numbers(HoudiniJson& json, const JsonToken& first, const AttributeSinks& sinks) {
  Paging paging;
  bool found = false;
  each_pair(json, first, [&](const std::string& name, const JsonToken& value) {
    if (name == "size") {
      if (whole_of(json, value, "the size of an attribute", kMostComponents) != sinks.size()) {
        json.expected("as many components as the attribute has");
      }
    } else if (name == "pagesize") {
      paging.page = whole_of(json, value, "the size of a page", kMaxPageElements);
    } else if (name == "packing") {
      json.each_number(value, [&](double part) {
        if (!(part >= 0 && part <= kMostComponents) || paging.packing.size() == kMostComponents) {
          json.expected("numbers of components");
        }
        paging.packing.push_back(static_cast<std::uint64_t>(part));
      });
    } else if (name == "constantpageflags") {
      read_constant_flags(json, value, sinks.points(), paging);
    } else if (name == "rawpagedata" && !found) {
      read_pages(json, value, paging, sinks);
      found = true;
    } else if ((name == "tuples" || name == "arrays") && !found) {
      read_all_numbers(json, value, name == "arrays", sinks);
      found = true;
    } else {
      json.skip_value(value);
    }
  });
  if (!found) json.expected("the values of an attribute");
}

// Reads the value of "options": names with maps of a type and a value.
void read_attribute_options(HoudiniJson& json, const JsonToken& first, HoudiniAttribute& attribute) {
  each_pair(json, first, [&](const std::string& name, const JsonToken& value) {
    if (name != "type" || value.kind != JsonToken::Kind::begin) {
      json.skip_value(value);
      return;
    }
    each_pair(json, value, [&](const std::string& key, const JsonToken& text) {
      if (key == "value" && text.kind == JsonToken::Kind::text) attribute.type_info = text.text;
      json.skip_value(text);
    });
  });
}

std::optional<AttributeKind> kind_of(const HoudiniAttribute& attribute) {
  if (attribute.type_info == "vector") return AttributeKind::vector;
  if (attribute.type_info == "normal") return AttributeKind::normal;
  if (attribute.type_info == "point") return AttributeKind::point;
  if (attribute.type_info == "color") return AttributeKind::color;
  return std::nullopt;
}

// State of the second pass: the result of the first, and the sinks for the numbers, sorted by column.
struct SecondPass {
  const HoudiniFile& first;
  std::span<const ColumnSink> sinks;

  // Returns the sinks of an attribute whose first component is column `first_column`.
  [[nodiscard]] std::span<const ColumnSink> sinks_of(std::size_t first_column, std::uint64_t components) const {
    const auto begin = std::ranges::lower_bound(sinks, first_column, {}, &ColumnSink::column);
    const auto end = std::ranges::lower_bound(sinks, first_column + components, {}, &ColumnSink::column);
    return {begin, end};
  }
};

void expect_unchanged(bool same, std::string_view what) {
  if (!same) {
    throw InvalidParticleFile(fmt::format("{} changed while the program read the file", what),
                              "run again when no other program writes to the file");
  }
}

// Reads one point attribute. In the second pass, `expected` is the attribute found here by the first pass, and `sinks`
// receive its numbers.
HoudiniAttribute read_attribute(HoudiniJson& json, const JsonToken& first, std::uint64_t points,
                                const HoudiniAttribute* expected, std::span<const ColumnSink> sinks,
                                std::size_t first_column) {
  if (first.kind != JsonToken::Kind::begin) json.expected("an attribute");
  HoudiniAttribute attribute;
  each_pair(json, json.next(), [&](const std::string& name, const JsonToken& value) {
    if (name == "name" && value.kind == JsonToken::Kind::text) attribute.name = value.text;
    if (name == "type" && value.kind == JsonToken::Kind::text) attribute.type = value.text;
    if (name == "options" && value.kind == JsonToken::Kind::begin) {
      read_attribute_options(json, value, attribute);
    } else {
      json.skip_value(value);
    }
  });
  bool has_values = false;
  HoudiniTexts texts;
  each_pair(json, json.next(), [&](const std::string& name, const JsonToken& value) {
    if (name == "size") attribute.size = whole_of(json, value, "the size of an attribute", kMostComponents);
    if (name == "storage" && value.kind == JsonToken::Kind::text) attribute.storage = value.text;
    const bool is_numeric = attribute.type == "numeric";
    if (name == "strings" && !is_numeric && !sinks.empty()) {
      json.each_text(value, [&](std::string_view text) { texts.add(text); });
    } else if (name == (is_numeric ? "values" : "indices") && !sinks.empty()) {
      read_attribute_numbers(json, value, AttributeSinks(points, expected->size, sinks, first_column, texts));
      has_values = true;
    } else {
      json.skip_value(value);
    }
  });
  if (json.next().kind != JsonToken::Kind::end) json.expected("the end of an attribute");
  if (expected != nullptr) expect_unchanged(attribute == *expected, "an attribute");
  // The particles' memory is not initialized, so missing values would be undefined.
  if (!sinks.empty() && !has_values) {
    json.expected(fmt::format("the values of the attribute '{}'", printable(attribute.name, 80)));
  }
  return attribute;
}

// Returns at least 1, as attributes are counted by columns.
std::size_t columns_of(const HoudiniAttribute& attribute) {
  return attribute.type == "numeric" ? std::max<std::size_t>(1, static_cast<std::size_t>(attribute.size)) : 1;
}

// Reads the whole file. The first pass, without `second`, finds its contents.
HoudiniFile parse_houdini(ContentReader& content, const SecondPass* second) {
  HoudiniJson json(content);
  HoudiniFile found;
  std::size_t columns = 0;
  bool has_count = false;
  const auto read_points = [&](const JsonToken& list) {
    if (list.kind != JsonToken::Kind::begin) json.expected("a list of attributes");
    if (!has_count) json.expected("the number of points before their attributes");
    for (JsonToken token = json.next(); token.kind != JsonToken::Kind::end; token = json.next()) {
      const HoudiniAttribute* expected = nullptr;
      std::span<const ColumnSink> sinks;
      if (second != nullptr) {
        const std::vector<HoudiniAttribute>& before = second->first.attributes;
        expect_unchanged(found.attributes.size() < before.size(), "the list of attributes");
        expected = &before[found.attributes.size()];
        sinks = second->sinks_of(columns, columns_of(*expected));
      }
      found.attributes.push_back(read_attribute(json, token, found.points, expected, sinks, columns));
      columns += columns_of(found.attributes.back());
      if (columns > kMaxParticleColumns) json.expected("fewer attributes");
    }
  };
  each_pair(json, json.next(), [&](const std::string& name, const JsonToken& value) {
    constexpr std::uint64_t kMost = std::uint64_t{1} << 48;
    if (name == "pointcount") {
      found.points = whole_of(json, value, "the number of points", kMost);
      if (second != nullptr) expect_unchanged(found.points == second->first.points, "the number of points");
      has_count = true;
    } else if (name == "primitivecount") {
      found.primitives = whole_of(json, value, "the number of primitives", kMost);
    } else if (name == "info" && value.kind == JsonToken::Kind::begin) {
      each_pair(json, value, [&](const std::string& key, const JsonToken& text) {
        if (key == "software" && text.kind == JsonToken::Kind::text) found.software = printable(text.text, 200);
        json.skip_value(text);
      });
    } else if (name == "attributes") {
      each_pair(json, value, [&](const std::string& owner, const JsonToken& list) {
        if (owner == "pointattributes") {
          read_points(list);
        } else {
          json.skip_value(list);
        }
      });
    } else {
      json.skip_value(value);
    }
  });
  if (second != nullptr) {
    expect_unchanged(found.attributes.size() == second->first.attributes.size(), "the list of attributes");
  }
  if (found.primitives > 0) {
    found.notes.push_back({NoteId::data_left_out,
                           fmt::format("the reader skips {} primitives and reads their points", found.primitives)});
  }
  return found;
}

ParticleTable houdini_table(const HoudiniFile& file) {
  ParticleTable table;
  for (const HoudiniAttribute& attribute : file.attributes) {
    const bool numeric = attribute.type == "numeric" && attribute.size > 0;
    if (attribute.name == "P" && numeric && attribute.size >= 3 && !table.position) {
      const std::size_t first = table.columns.size();
      table.position = {first, first + 1, first + 2};
    }
    const std::string type = numeric ? attribute.storage : attribute.type == "string" ? "text" : attribute.type;
    add_tuple(table, attribute.name, printable(type, 40), columns_of(attribute), numeric, kind_of(attribute));
    if (!numeric) table.columns.back().has_words = attribute.type == "string" && attribute.size == 1;
  }
  table.has_words = true;
  make_group_names_unique(table);
  if (!table.position) throw InvalidParticleFile("expected the attribute P of points, found none");
  return table;
}

}  // namespace

HoudiniFile scan_houdini(const files::InputFile& file) {
  const files::FileVersion version = must(files::version_of(file));
  ContentReader content(file);
  HoudiniFile found = parse_houdini(content, nullptr);
  found.version = version;
  return found;
}

ParticleInfo houdini_info(const files::InputFile& file, const ParticleReadOptions& options) {
  const HoudiniFile found = scan_houdini(file);
  ParticleInfo info;
  info.particles = found.points;
  info.notes = found.notes;
  describe_table(houdini_table(found), options, info);
  return info;
}

ParticleFile read_houdini(const files::InputFile& file, const HoudiniFile& surveyed,
                          const ParticleReadOptions& options) {
  const ColumnChoice choice = choose_columns(houdini_table(surveyed), options);
  ContentReader content(file);
  // Each page of P has at least one tuple.
  check_count(content, (surveyed.points + kMaxPageElements - 1) / kMaxPageElements, 3);
  ParticleFile result;
  result.particles = make_particles(file.context(), file.name(), surveyed.points, choice);
  if (surveyed.points > 0) {
    const std::vector<ColumnSink> sinks = sinks_of(result.particles, choice);
    const SecondPass second{surveyed, sinks};
    parse_houdini(content, &second);
    must(files::check_unchanged(file, surveyed.version));
  }
  result.creator = surveyed.software.starts_with("Houdini") ? surveyed.software : kHoudiniFormat;
  result.notes = surveyed.notes;
  result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
  return result;
}

}  // namespace isoextract::particle_io
