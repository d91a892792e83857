#include "points/element_radii.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "points/sphere_set.hpp"

namespace isoextract::points {
namespace {

struct Element {
  std::string_view symbol;
  double van_der_waals;  // in angstrom; 0 if unknown
  double covalent;
};

// By atomic number, from 1 on.
constexpr std::array kElements{
    Element{"H", 1.1, 0.31},   Element{"He", 1.4, 0.28},  Element{"Li", 1.81, 1.28}, Element{"Be", 1.53, 0.96},
    Element{"B", 1.92, 0.84},  Element{"C", 1.7, 0.76},   Element{"N", 1.55, 0.71},  Element{"O", 1.52, 0.66},
    Element{"F", 1.47, 0.57},  Element{"Ne", 1.54, 0.58}, Element{"Na", 2.27, 1.66}, Element{"Mg", 1.73, 1.41},
    Element{"Al", 1.84, 1.21}, Element{"Si", 2.1, 1.11},  Element{"P", 1.8, 1.07},   Element{"S", 1.8, 1.05},
    Element{"Cl", 1.75, 1.02}, Element{"Ar", 1.88, 1.06}, Element{"K", 2.75, 2.03},  Element{"Ca", 2.31, 1.76},
    Element{"Sc", 2.58, 1.7},  Element{"Ti", 2.46, 1.6},  Element{"V", 2.42, 1.53},  Element{"Cr", 2.45, 1.39},
    Element{"Mn", 2.45, 1.39}, Element{"Fe", 2.44, 1.32}, Element{"Co", 2.4, 1.26},  Element{"Ni", 2.4, 1.24},
    Element{"Cu", 2.38, 1.32}, Element{"Zn", 2.39, 1.22}, Element{"Ga", 1.87, 1.22}, Element{"Ge", 2.11, 1.2},
    Element{"As", 1.85, 1.19}, Element{"Se", 1.9, 1.2},   Element{"Br", 1.83, 1.2},  Element{"Kr", 2.02, 1.16},
    Element{"Rb", 3.03, 2.2},  Element{"Sr", 2.49, 1.95}, Element{"Y", 2.75, 1.9},   Element{"Zr", 2.52, 1.75},
    Element{"Nb", 2.56, 1.64}, Element{"Mo", 2.45, 1.54}, Element{"Tc", 2.44, 1.47}, Element{"Ru", 2.46, 1.46},
    Element{"Rh", 2.44, 1.42}, Element{"Pd", 2.15, 1.39}, Element{"Ag", 2.53, 1.45}, Element{"Cd", 2.49, 1.44},
    Element{"In", 1.93, 1.42}, Element{"Sn", 2.17, 1.39}, Element{"Sb", 2.06, 1.39}, Element{"Te", 2.06, 1.38},
    Element{"I", 1.98, 1.39},  Element{"Xe", 2.16, 1.4},  Element{"Cs", 3.43, 2.44}, Element{"Ba", 2.68, 2.15},
    Element{"La", 2.98, 2.07}, Element{"Ce", 2.88, 2.04}, Element{"Pr", 2.92, 2.03}, Element{"Nd", 2.95, 2.01},
    Element{"Pm", 0, 1.99},    Element{"Sm", 2.9, 1.98},  Element{"Eu", 2.87, 1.98}, Element{"Gd", 2.83, 1.96},
    Element{"Tb", 2.79, 1.94}, Element{"Dy", 2.87, 1.92}, Element{"Ho", 2.81, 1.92}, Element{"Er", 2.83, 1.89},
    Element{"Tm", 2.79, 1.9},  Element{"Yb", 2.8, 1.87},  Element{"Lu", 2.74, 1.87}, Element{"Hf", 2.63, 1.75},
    Element{"Ta", 2.53, 1.7},  Element{"W", 2.57, 1.62},  Element{"Re", 2.49, 1.51}, Element{"Os", 2.48, 1.44},
    Element{"Ir", 2.41, 1.41}, Element{"Pt", 2.29, 1.36}, Element{"Au", 2.32, 1.36}, Element{"Hg", 2.45, 1.32},
    Element{"Tl", 1.96, 1.45}, Element{"Pb", 2.02, 1.46}, Element{"Bi", 2.07, 1.48}, Element{"Po", 1.97, 1.4},
    Element{"At", 2.02, 1.5},  Element{"Rn", 2.2, 1.5},   Element{"Fr", 3.48, 2.6},  Element{"Ra", 2.83, 2.21},
    Element{"Ac", 2.8, 2.15},  Element{"Th", 2.93, 2.06}, Element{"Pa", 2.88, 2},    Element{"U", 2.71, 1.96},
    Element{"Np", 2.82, 1.9},  Element{"Pu", 2.81, 1.87}, Element{"Am", 2.83, 1.8},  Element{"Cm", 3.05, 1.69},
    Element{"Bk", 3.4, 0},     Element{"Cf", 3.05, 0},    Element{"Es", 2.7, 0}};

std::optional<double> radius_of(ElementRadii radii, const Element& element) {
  const double radius = radii == ElementRadii::covalent ? element.covalent : element.van_der_waals;
  return radius > 0 ? std::optional(radius) : std::nullopt;
}

// Returns the word without digits and signs of a charge at its ends.
std::string_view letters_of(std::string_view word) {
  while (!word.empty() && !is_letter(word.front())) word.remove_prefix(1);
  while (!word.empty() && !is_letter(word.back())) word.remove_suffix(1);
  return word;
}

std::string kind_name(ElementRadii radii) {
  return radii == ElementRadii::covalent ? "a covalent radius" : "a van der Waals radius";
}

// Counts the particles whose word or number is no element with a radius.
struct UnknownElements {
  std::size_t count = 0;
  std::size_t first = 0;  // particle
  std::string found;      // its word or number

  template <class Text>
  void add(std::size_t particle, const Text& text) {
    if (count++ > 0) return;
    first = particle;
    found = text();
  }
};

const ParticleWords* find_words(const ParticleSet& particles, std::string_view name) {
  const auto found = std::ranges::find(particles.words, name, &ParticleWords::name);
  return found == particles.words.end() || found->too_many ? nullptr : &*found;
}

// The words or numbers that state the elements of particles; one of `words` and `numbers` is set.
struct ElementSource {
  const ParticleWords* words = nullptr;
  const ParticleAttribute* numbers = nullptr;
  const ParticleWords* residues = nullptr;  // set if `words` are names of atoms, and there are residues
  bool by_name = false;
};

std::optional<ElementSource> find_elements(const ParticleSet& particles) {
  for (const std::string_view name : kElementAttributes) {
    if (const ParticleWords* const words = find_words(particles, name)) return ElementSource{.words = words};
    const auto numbers = std::ranges::find(particles.attributes, name, &ParticleAttribute::name);
    if (numbers != particles.attributes.end() && numbers->components == 1) return ElementSource{.numbers = &*numbers};
  }
  if (const ParticleWords* const names = find_words(particles, kAtomName)) {
    return ElementSource{.words = names, .residues = find_words(particles, kResidueName), .by_name = true};
  }
  return std::nullopt;
}

// Writes the radius of each particle in angstrom, 0 if it is unknown.
UnknownElements write_radii(const ElementSource& source, ElementRadii radii, std::span<float> out) {
  UnknownElements unknown;
  if (source.numbers != nullptr) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const auto number = static_cast<double>(source.numbers->values[i]);
      const auto radius = element_radius(radii, number);
      out[i] = static_cast<float>(radius.value_or(0));
      if (!radius) unknown.add(i, [&] { return fmt::format("{:.6g}", number); });
    }
    return unknown;
  }
  const std::vector<std::string>& words = source.words->words;
  std::vector<std::optional<double>> by_word;
  for (const std::string& word : words) by_word.push_back(element_radius(radii, letters_of(word)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::uint32_t word = source.words->indices[i];
    std::optional<double> radius = by_word[word];
    if (source.by_name) {
      const std::string_view residue =
          source.residues != nullptr ? source.residues->words[source.residues->indices[i]] : std::string_view();
      radius = element_radius(radii, element_of_atom(words[word], residue));
    }
    out[i] = static_cast<float>(radius.value_or(0));
    if (!radius) unknown.add(i, [&] { return printable(words[word], 40); });
  }
  return unknown;
}

// Replaces the attribute that gives the radii, or adds one.
void set_radius_attribute(ParticleSet& particles, Buffer<float> values) {
  for (const std::string_view name : kRadiusAttributes) {
    for (ParticleAttribute& attribute : particles.attributes) {
      if (attribute.name != name || attribute.components != 1) continue;
      attribute.values = std::move(values);
      return;
    }
  }
  particles.attributes.push_back({std::string(kRadiusAttributes.back()), 1, std::move(values)});
}

}  // namespace

std::optional<double> element_radius(ElementRadii radii, std::string_view symbol) {
  if (symbol == "D" || symbol == "T") return element_radius(radii, "H");
  const auto is_it = [&](const Element& element) { return to_lower(element.symbol) == to_lower(symbol); };
  const auto* const found = std::ranges::find_if(kElements, is_it);
  return found == kElements.end() ? std::nullopt : radius_of(radii, *found);
}

std::optional<double> element_radius(ElementRadii radii, double atomic_number) {
  if (!(atomic_number >= 1 && atomic_number <= kElements.size()) || std::floor(atomic_number) != atomic_number) {
    return std::nullopt;
  }
  return radius_of(radii, kElements[static_cast<std::size_t>(atomic_number) - 1]);
}

std::string_view element_of_atom(std::string_view name, std::string_view residue) {
  const std::string_view letters = letters_of(name);
  if (letters.empty() || letters == letters_of(residue)) return letters;
  const bool is_pair = letters.size() > 1 && letters[1] >= 'a' && letters[1] <= 'z';
  return letters.substr(0, is_pair ? 2 : 1);
}

Result<std::string> set_element_radii(ParticleSet& particles, ElementRadii radii, double angstrom,
                                      const Context& context) {
  const auto source = find_elements(particles);
  if (!source && particles.size() > 0) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected an attribute 'species', 'element' or 'symbol' with the element of each "
                            "particle, or 'name' with the names of atoms, found none",
                            particles.label),
                {Remedy::give, Setting::radius});
  }
  auto memory = TRY(context.reserve(particles.size() * sizeof(float), particles.label + ": radii of elements"));
  Buffer<float> values(particles.size());
  std::string stated;
  if (source) {
    stated = source->numbers != nullptr ? source->numbers->name : source->words->name;
    const UnknownElements unknown = write_radii(*source, radii, values.span());
    if (unknown.count > 0) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected elements with {} in the attribute '{}', found '{}' at particle {}; "
                              "{} of {} particles have no such element",
                              particles.label, kind_name(radii), printable(stated), unknown.found, unknown.first,
                              unknown.count, particles.size()),
                  {{Remedy::set, Setting::selection, "CONDITION to leave such particles out"},
                   {Remedy::give, Setting::radius}});
    }
  }
  for (float& value : values) value = static_cast<float>(static_cast<double>(value) * angstrom);
  set_radius_attribute(particles, std::move(values));
  particles.memory.take(std::move(memory));
  return stated;
}

}  // namespace isoextract::points
