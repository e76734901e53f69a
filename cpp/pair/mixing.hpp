// Mixing rules: the parameters and the drag of a missing pair i–j from those of i–i and j–j.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace dlpoly::pair {

enum class MixingRule {
    lorentz_berthelot,
    fender_halsey,
    hogervorst,
    halgren,
    waldman_hagler,
    tang_toennies,
    functional,
};

// In the order of MixingRule.
inline constexpr std::array<std::string_view, 7> mixing_rule_names{
    "lorentz-berthelot", "fender-halsey", "hogervorst", "halgren", "waldman-hagler", "tang-toennies", "functional"};

// A rule by its name or its four-letter keyword of an old CONTROL, in any case, with '-', '_' or ' ' between the words;
// DL_POLY's own misspellings tang-tonnies and fender-hasley are accepted. Throws std::invalid_argument.
MixingRule find_mixing_rule(std::string_view name);

// What the rules are written for: eps (A of dpd), sig (rc of dpd, r0 of 14-7) and the drag of one species with itself.
struct Mixed {
    double energy;
    double length;
    double drag;
};

// One function a rule. Energies, lengths and drags are not negative; a mean of zeros is zero; where a rule divides by
// an energy or a length that is zero and has no limit, std::invalid_argument says which numbers it needs.
Mixed lorentz_berthelot(const Mixed& i, const Mixed& j);  // eps geometric, sig arithmetic, drag geometric
Mixed fender_halsey(const Mixed& i, const Mixed& j);      // eps harmonic, sig arithmetic, drag harmonic
Mixed hogervorst(const Mixed& i, const Mixed& j);         // all geometric
Mixed halgren(const Mixed& i, const Mixed& j);            // eps, drag 4ab/(√a + √b)²; sig Σs³/Σs²
Mixed waldman_hagler(const Mixed& i, const Mixed& j);     // sig⁶ arithmetic; eps sig⁶ and drag sig⁶ geometric
Mixed tang_toennies(const Mixed& i, const Mixed& j);      // eps sig⁶ geometric, (eps sig¹²)^(1/13) arithmetic
Mixed functional(const Mixed& i, const Mixed& j);         // means over three powers of sig
Mixed mix(MixingRule rule, const Mixed& i, const Mixed& j);

// A second length of a law (D of wca, ri of mlj and m126), mixed by the mean the rule uses for sig; the two rules
// without a mean of lengths alone keep its average ratio to sig.
double mix_length(MixingRule rule, double length_i, double length_j, const Mixed& i, const Mixed& j,
                  const Mixed& mixed);

struct MixedPair {
    std::vector<double> parameters;
    double drag;
};

// The parameters of one mixable law (LawInfo::mixable) for the pair i–j. 12-6 and m126 are converted with
// eps = B²/(4A), sig = (A/B)^(1/6) and back; c of ljc, a factor of the r⁻⁶ attraction, mixes geometrically, as the
// attraction itself does in the rule of Berthelot. DL_POLY, once its crash is mended, would mix A and B of m126 as if
// they were eps and sig and would lose c and ri. Throws std::invalid_argument.
MixedPair mix(MixingRule rule, std::string_view key, std::span<const double> parameters_i,
              std::span<const double> parameters_j, double drag_i, double drag_j);

}  // namespace dlpoly::pair
