// Radii of atoms by their element.
//
// van der Waals radii, in angstrom: for the main group, the radii of table 12 of M. Mantina, A. C. Chamberlin, R.
// Valero, C. J. Cramer, D. G. Truhlar: Consistent van der Waals radii for the whole main group. J. Phys. Chem. A 113,
// 2009. Their table has the radii of A. Bondi (J. Phys. Chem. 68, 1964) where they exist, except for hydrogen (1.10;
// Bondi's is 1.20). For the other elements, the radii are from S. Alvarez: A cartography of the van der Waals
// territories. Dalton Trans. 42, 2013.
//
// Covalent radii, in angstrom: B. Cordero et al.: Covalent radii revisited. Dalton Trans., 2008. The radius of carbon
// is for sp3; the radii of Mn, Fe and Co are for low spin.
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

// Returns the radius in angstrom of an element: by its symbol, ignoring case, or by its atomic number. D and T, in
// capitals, are hydrogen. Returns nullopt for other words, and if the source gives no radius.
[[nodiscard]] std::optional<double> element_radius(ElementRadii radii, std::string_view symbol);
[[nodiscard]] std::optional<double> element_radius(ElementRadii radii, double atomic_number);

// Attributes that state the element of each particle; the first one found counts. The values are words with or without
// a charge ("Na+"), or atomic numbers.
inline constexpr std::array<std::string_view, 3> kElementAttributes{"species", "element", "symbol"};

// Without these attributes, the name of an atom gives its element by the rule of element_of_atom().
inline constexpr std::string_view kAtomName = "name";
inline constexpr std::string_view kResidueName = "residue";

// Returns the symbol of an element from the name of an atom ("CA", "HW1"). Ignores digits and signs at both ends.
// Returns the whole name if the residue has the same name, as for ions (atom "NA" of residue "NA"). Else returns the
// first letter, or the first two if the second is lower case ("Cl1").
[[nodiscard]] std::string_view element_of_atom(std::string_view name, std::string_view residue);

// Gives the particles the radii of their elements, as if the file had the attribute "radius". An existing attribute of
// kRadiusAttributes gets these values instead. `angstrom` is the length of an angstrom in the unit of the positions.
// Returns the name of the attribute that states the elements; kAtomName if the names of atoms give them. A set without
// particles needs no such attribute.
//
// Fails with ErrorCode::input if no attribute states the elements, and if a word or number is no element with a radius.
// Fails as Context::reserve() does.
[[nodiscard]] Result<std::string> set_element_radii(ParticleSet& particles, ElementRadii radii, double angstrom,
                                                    const Context& context);

}  // namespace isoextract::points
