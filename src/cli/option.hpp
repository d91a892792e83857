// An option: its one declaration, and what was given for it. Each is a member of the flags of its commands:
//
//   struct RunFlags : OptionSet {
//     Value<int> threads{*this, "--threads", "N", parse_thread_count, "Threads to use (default: all)."};
//     Flag quiet{*this, "-q,--quiet", "Say nothing but errors."};
//   };
//
// Parser, help, man page, completions, --config and the errors about options without an effect are made from these.
// A metavar with '|' in it ("mc|mt") lists all values; FILE and INPUT are completed with paths.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/error.hpp"

namespace isoextract::cli {

// The groups that options are in, in the order of the help.
enum class OptionGroup {
  input,
  scene,
  simulation,
  particles,
  frames,
  surface,
  pieces,
  vertices,
  placement,
  output,
  run
};
constexpr auto words_of(OptionGroup /*type*/) {
  return std::array{Word{OptionGroup::input, "Input"},
                    Word{OptionGroup::scene, "Scene"},
                    Word{OptionGroup::simulation, "Simulation"},
                    Word{OptionGroup::particles, "Particles"},
                    Word{OptionGroup::frames, "Frames"},
                    Word{OptionGroup::surface, "Surface"},
                    Word{OptionGroup::pieces, "Pieces"},
                    Word{OptionGroup::vertices, "Vertices"},
                    Word{OptionGroup::placement, "Placement"},
                    Word{OptionGroup::output, "Output"},
                    Word{OptionGroup::run, "Run"}};
}

// What an option is about. Where there is none of it, the option has no effect and is refused (OptionSet::refuse).
enum class About : std::uint32_t {
  anything = 0,
  surface = 1U << 0,        // not where the field itself is written
  mesh_file = 1U << 1,      // not where a picture is drawn
  picture = 1U << 2,        // only where one is drawn
  edit = 1U << 3,           // changes a surface after its extraction
  world = 1U << 4,          // not with voxel coordinates
  raw_file = 1U << 5,       // only with the samples of a raw file
  gpu = 1U << 6,            // not on the processor
  weights = 1U << 7,        // only of particles that add a weight
  extraction = 1U << 8,     // not where nothing is extracted
  drawn_surface = 1U << 9,  // only of surfaces of a volume that is drawn
  drawn_volume = 1U << 10,  // only of a volume that is drawn
  voxel_faces = 1U << 11,   // only of the method of voxel faces
};
constexpr About operator|(About a, About b) {
  return static_cast<About>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr About operator&(About a, About b) {
  return static_cast<About>(static_cast<std::uint32_t>(a) & static_cast<std::uint32_t>(b));
}

// How much the help of a command says.
enum class HelpDetail {
  summaries,  // a line an option: --help
  all,        // the whole text of each option, and examples: --help-all
};

class Option;
class OptionSet;

// Where an option is declared: in a group of a set. Without a set no command has it, and it is never set.
struct Place {
  OptionSet* set = nullptr;
  OptionGroup group = OptionGroup::run;
  bool everyday = false;  // the overview of the help shows it: few options are
};
[[nodiscard]] inline Place everyday(Place place) {
  place.everyday = true;
  return place;
}

// The options of a command or of a part of it: the base of flags, whose members they are. A copy of flags has options
// of its own: the set knows its options by their distance from itself, so it is copied as a part of all its flags only.
class OptionSet {
 public:
  OptionSet() = default;
  // A part, whose options are those of `whole`, too.
  OptionSet(OptionSet& whole, OptionGroup group) : OptionSet(&whole, group) {}

  // The place of options in the group of the part, and in any group.
  operator Place() { return {this, group_}; }  // NOLINT(google-explicit-constructor): an option is put into a set
  [[nodiscard]] Place in(OptionGroup group) { return {this, group}; }

  // In the order of their declaration, but those of a group together, and the group "Run" last.
  [[nodiscard]] std::vector<Option*> options();
  [[nodiscard]] std::vector<const Option*> options() const;
  [[nodiscard]] std::vector<const Option*> in_group(OptionGroup group) const;
  // By one of its names, or nullptr.
  [[nodiscard]] const Option* find(std::string_view name) const;
  // The first that is given by its place, or nullptr.
  [[nodiscard]] const Option* operand() const;
  [[nodiscard]] bool any_set() const;

  // All that are set, and about `what`.
  [[nodiscard]] std::vector<const Option*> set_about(About what) const;
  // Fails with ErrorCode::usage where there is one. In `why` and `hint` the first of them takes the place of {}.
  [[nodiscard]] Result<void> refuse(About what, std::string_view why, std::string_view hint = "") const;

 protected:
  // A part of nothing, where there is no whole.
  OptionSet(OptionSet* whole, OptionGroup group) : whole_(whole), group_(group) {}
  OptionSet(const OptionSet&) = default;
  OptionSet& operator=(const OptionSet&) = default;
  ~OptionSet() = default;

 private:
  friend class Option;
  void add(const Option& option);
  [[nodiscard]] const Option& at(std::ptrdiff_t distance) const;

  OptionSet* whole_ = nullptr;  // while options are declared
  OptionGroup group_ = OptionGroup::run;
  std::vector<std::ptrdiff_t> options_;
};

// A word of the command line and what it means.
template <class T>
struct Choice {
  std::string name;
  T value;
};

// The value that is meant where an option's own is left out.
struct IfLeftOut {
  std::string text;
};

// The words of an option, and where it has an effect.
struct OptionRow {
  OptionGroup group = OptionGroup::run;
  std::vector<std::string> names;  // with their dashes, the long one last; one without dashes is positional
  std::string metavar;             // empty: takes no value
  std::string help;                // the first sentence is the summary: at most kSummaryWidth characters
  About about = About::anything;
  std::size_t most = 1;                 // values
  std::optional<std::string> left_out;  // the value may be left out, and this one is meant
  bool everyday = false;
};

class Option {
 public:
  virtual ~Option() = default;

  [[nodiscard]] const OptionRow& row() const { return *row_; }
  [[nodiscard]] const std::string& name() const { return row_->names.back(); }  // "--output"
  [[nodiscard]] std::string key() const { return name().substr(2); }            // "output", as --config has it
  [[nodiscard]] std::string spelling() const;                                   // "-o, --output FILE"
  [[nodiscard]] std::vector<std::string> choices() const;                       // empty: takes any value
  [[nodiscard]] bool is_positional() const { return !row_->names.back().starts_with('-'); }
  [[nodiscard]] bool takes_file() const;
  [[nodiscard]] bool takes_value() const { return !row_->metavar.empty(); }
  [[nodiscard]] bool is_repeatable() const { return row_->most > 1; }
  [[nodiscard]] bool is_about(About what) const { return (row_->about & what) == what; }

  // What was given for it on the command line, word for word. take() makes values of them; its errors begin with the
  // option's name.
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }
  void add_text(std::string text) { texts_.push_back(std::move(text)); }
  [[nodiscard]] virtual Result<void> take() = 0;

  // Which help the option asks for; none for all options but HelpFlag.
  [[nodiscard]] virtual std::optional<HelpDetail> help() const { return std::nullopt; }

  // Whether it has a value now, whoever gave it.
  [[nodiscard]] virtual bool is_set() const = 0;

 protected:
  Option(const Place& place, OptionRow row);
  Option(const Option&) = default;
  Option(Option&&) = default;
  Option& operator=(const Option&) = default;
  Option& operator=(Option&&) = default;

  [[nodiscard]] tl::unexpected<Error> refuse(Error why) const;

 private:
  std::shared_ptr<const OptionRow> row_;
  std::vector<std::string> texts_;
};

// "a,b" as {"a", "b"}.
[[nodiscard]] std::vector<std::string> split_names(std::string_view names);
// "mc|mt"
[[nodiscard]] std::string metavar_of(const std::vector<std::string>& words);
// The place of `text` among `words`, or an error that names the nearest of them.
[[nodiscard]] Result<std::size_t> place_among(const std::vector<std::string>& words, std::string_view text);

template <class T>
std::vector<std::string> words_of_choices(const std::vector<Choice<T>>& choices) {
  std::vector<std::string> words;
  for (const Choice<T>& choice : choices) words.push_back(choice.name);
  return words;
}

template <class E>
std::vector<Choice<E>> choices_of_words() {
  std::vector<Choice<E>> choices;
  for (const Word<E>& entry : words_of(E{})) choices.push_back({std::string(entry.word), entry.value});
  return choices;
}

template <class E>
concept HasWords = requires {
  words_of(E{});
};

template <class T>
using Parse = std::function<Result<T>(std::string_view)>;

// Fails with ErrorCode::usage if both are set: "--scale and --unit exclude each other: WHY".
[[nodiscard]] Result<void> refuse_both(const Option& a, const Option& b, std::string_view why = "", Hint hint = {});

// An option with one value.
template <class T>
class Value : public Option, public std::optional<T> {
 public:
  Value(const Place& place, std::string_view names, std::string metavar, Parse<T> parse, std::string help,
        About about = About::anything, std::optional<IfLeftOut> left_out = std::nullopt)
      : Option(place, {place.group, split_names(names), std::move(metavar), std::move(help), about, 1,
                       left_out ? std::optional(left_out->text) : std::nullopt}),
        parse_(std::move(parse)) {}

  // Of an enum, by its own words.
  Value(const Place& place, std::string_view names, std::string help,
        About about = About::anything) requires HasWords<T>
      : Value(place, names, choices_of_words<T>(), std::move(help), about) {}

  Value(const Place& place, std::string_view names, const std::vector<Choice<T>>& choices, std::string help,
        About about = About::anything, std::optional<IfLeftOut> left_out = std::nullopt)
      : Value(
            place, names, metavar_of(words_of_choices(choices)),
            [choices](std::string_view text) -> Result<T> {
              const std::size_t at = TRY(place_among(words_of_choices(choices), text));
              return choices[at].value;
            },
            std::move(help), about, std::move(left_out)) {}

  using std::optional<T>::operator=;

  [[nodiscard]] bool is_set() const override { return this->has_value(); }

  [[nodiscard]] Result<void> take() override {
    for (const std::string& text : texts()) {
      auto value = parse_(text);
      if (!value) return refuse(std::move(value.error()));
      *this = std::move(*value);
    }
    return {};
  }

 private:
  Parse<T> parse_;
};

// An option that may be given several times.
template <class T>
class Values : public Option, public std::vector<T> {
 public:
  Values(const Place& place, std::string_view names, std::string metavar, Parse<T> parse, std::string help,
         About about = About::anything, std::size_t most = SIZE_MAX)
      : Option(place, {place.group, split_names(names), std::move(metavar), std::move(help), about, most, {}}),
        parse_(std::move(parse)) {}

  using std::vector<T>::operator=;

  [[nodiscard]] bool is_set() const override { return !this->empty(); }

  [[nodiscard]] Result<void> take() override {
    this->clear();
    for (const std::string& text : texts()) {
      auto value = parse_(text);
      if (!value) return refuse(std::move(value.error()));
      this->push_back(std::move(*value));
    }
    return {};
  }

 private:
  Parse<T> parse_;
};

// An option without a value.
class Flag : public Option {
 public:
  Flag(const Place& place, std::string_view names, std::string help, About about = About::anything)
      : Option(place, {place.group, split_names(names), "", std::move(help), about, 1, {}}) {}

  Flag& operator=(bool on) {
    on_ = on;
    return *this;
  }
  operator bool() const { return on_; }  // NOLINT(google-explicit-constructor): reads as the bool that it stands for

  [[nodiscard]] bool is_set() const override { return on_; }
  [[nodiscard]] Result<void> take() override {
    on_ = on_ || !texts().empty();
    return {};
  }

 private:
  bool on_ = false;
};

// An option that asks for help in place of a run.
class HelpFlag : public Flag {
 public:
  HelpFlag(const Place& place, std::string_view names, HelpDetail detail, std::string help)
      : Flag(place, names, std::move(help)), detail_(detail) {}

  [[nodiscard]] std::optional<HelpDetail> help() const override { return detail_; }

 private:
  HelpDetail detail_;
};

}  // namespace isoextract::cli
