// The list of all bonded laws and the ways to find one; a new law is one header and one line here.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "bonded/angle_compass.hpp"
#include "bonded/angle_cosine.hpp"
#include "bonded/angle_harmonic.hpp"
#include "bonded/angle_harmonic_cosine.hpp"
#include "bonded/angle_kumagai.hpp"
#include "bonded/angle_mm3.hpp"
#include "bonded/angle_quartic.hpp"
#include "bonded/angle_screened.hpp"
#include "bonded/angle_stretch_bend.hpp"
#include "bonded/angle_stretch_bend_mm3.hpp"
#include "bonded/angle_stretch_stretch.hpp"
#include "bonded/angle_truncated.hpp"
#include "bonded/angle_vessal_first.hpp"
#include "bonded/angle_vessal_second.hpp"
#include "bonded/bond_buckingham.hpp"
#include "bonded/bond_coulomb.hpp"
#include "bonded/bond_fene.hpp"
#include "bonded/bond_harmonic.hpp"
#include "bonded/bond_lennard_jones.hpp"
#include "bonded/bond_mm3.hpp"
#include "bonded/bond_morse.hpp"
#include "bonded/bond_quartic.hpp"
#include "bonded/bond_restrained.hpp"
#include "bonded/bond_twelve_six.hpp"
#include "bonded/dihedral_cosine.hpp"
#include "bonded/dihedral_harmonic.hpp"
#include "bonded/dihedral_harmonic_cosine.hpp"
#include "bonded/dihedral_opls.hpp"
#include "bonded/dihedral_ryckaert_bellemans.hpp"
#include "bonded/dihedral_ryckaert_fluorinated.hpp"
#include "bonded/dihedral_triple_cosine.hpp"
#include "bonded/inversion_calcite.hpp"
#include "bonded/inversion_extended_planar.hpp"
#include "bonded/inversion_harmonic.hpp"
#include "bonded/inversion_harmonic_cosine.hpp"
#include "bonded/inversion_planar.hpp"
#include "bonded/law.hpp"
#include "bonded/tabulated.hpp"
#include "bonded/tether_harmonic.hpp"
#include "bonded/tether_quartic.hpp"
#include "bonded/tether_restrained.hpp"

namespace dlpoly::bonded {

template <class... Types>
struct TypeList {};

using Laws =
    TypeList<HarmonicBond, MorseBond, TwelveSixBond, LennardJonesBond, RestrainedBond, QuarticBond, BuckinghamBond,
             CoulombBond, FeneBond, Mm3Bond, HarmonicAngle, QuarticAngle, TruncatedAngle, ScreenedAngle,
             FirstVessalAngle, SecondVessalAngle, HarmonicCosineAngle, CosineAngle, StretchBendMm3Angle,
             StretchStretchAngle, StretchBendAngle, CompassAngle, Mm3Angle, KumagaiAngle, CosineDihedral,
             HarmonicDihedral, HarmonicCosineDihedral, TripleCosineDihedral, RyckaertBellemansDihedral,
             FluorinatedRyckaertDihedral, OplsDihedral, HarmonicInversion, HarmonicCosineInversion, PlanarInversion,
             ExtendedPlanarInversion, CalciteInversion, HarmonicTether, RestrainedTether, QuarticTether, TabulatedBond,
             TabulatedAngle, TabulatedDihedral, TabulatedInversion>;

// Calls f.template operator()<Law>() for every law, in the order of the list.
template <class Function>
void for_each_law(Function&& f) {
    [&]<class... Law>(TypeList<Law...>) { (f.template operator()<Law>(), ...); }(Laws{});
}

// Calls f.template operator()<Law>() for the law of this kind and key; an unknown one throws std::invalid_argument.
template <class Function>
void visit(Kind kind, std::string_view key, Function&& f) {
    bool found = false;
    for_each_law([&]<class Law>() {
        if (!found && Law::info.kind == kind && Law::info.key == key) {
            found = true;
            f.template operator()<Law>();
        }
    });
    if (!found) throw std::invalid_argument("unknown " + std::string(name(kind)) + " law '" + std::string(key) + "'");
}

}  // namespace dlpoly::bonded
