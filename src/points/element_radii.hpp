// Radii of atoms by their element.
//
// van der Waals radii, in angstrom: for the main group those of table 12 of M. Mantina, A. C. Chamberlin, R. Valero, C.
// J. Cramer, D. G. Truhlar: Consistent van der Waals radii for the whole main group. J. Phys. Chem. A 113, 2009. The
// table keeps those of A. Bondi (J. Phys. Chem. 68, 1964) where he gives one, but for hydrogen (1.10; Bondi's is 1.20).
// For the other elements those of S. Alvarez: A cartography of the van der Waals territories. Dalton Trans. 42, 2013.
//
// Covalent radii, in angstrom: B. Cordero et al.: Covalent radii revisited. Dalton Trans., 2008. Of carbon that of sp3,
// of Mn, Fe and Co those of low spin.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

enum class ElementRadii { van_der_waals, covalent };
constexpr auto words_of(ElementRadii /*type*/) {
  return std::array{Word{ElementRadii::van_der_waals, "element"}, Word{ElementRadii::covalent, "covalent"}};
}

// Returns the radius in angstrom of an element: by its symbol, ignoring case, or by its atomic number. D and T are
// hydrogen. Returns nullopt for other words, and if the source gives none.
[[nodiscard]] std::optional<double> element_radius(ElementRadii radii, std::string_view symbol);
[[nodiscard]] std::optional<double> element_radius(ElementRadii radii, double atomic_number);

// Attributes that state the element of each particle; the first one found counts. As words with or without a charge
// ("Na+"), or as atomic numbers.
inline constexpr std::array<std::string_view, 3> kElementAttributes{"species", "element", "symbol"};

// Without these, the name of an atom gives its element by the rule of element_of_atom().
inline constexpr std::string_view kAtomName = "name";
inline constexpr std::string_view kResidueName = "residue";

// Returns the symbol by the name of an atom ("CA", "HW1"), without digits and charges. It is the whole name if that is
// the name of the residue, as of ions ("NA" of "NA"). Else it is the first letter, or the first two if the second is
// lower case ("Cl1").
[[nodiscard]] std::string_view element_of_atom(std::string_view name, std::string_view residue);

// Gives the particles the radii of their elements, as if the file had the attribute "radius" (kRadiusAttributes); an
// attribute of that kind that they have gets these values. `angstrom` is the length of an angstrom in the unit of the
// positions. Returns the name of the attribute that states the elements; kAtomName if names give them.
//
// Fails with ErrorCode::input if no attribute states the elements, and if a word or number is no element with a radius.
// Fails as Context::reserve() does.
[[nodiscard]] Result<std::string> set_element_radii(ParticleSet& particles, ElementRadii radii, double angstrom,
                                                    const Context& context);

}  // namespace isoextract::points
