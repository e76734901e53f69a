// The seven mixing rules and how each mixable pair law's parameters enter them.
#include "pair/mixing.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "pair/arithmetic.hpp"
#include "pair/registry.hpp"

namespace dlpoly::pair {

namespace {

double geometric(double a, double b) { return std::sqrt(a * b); }

double harmonic(double a, double b) { return a + b > 0.0 ? 2.0 * a * b / (a + b) : 0.0; }

// Halgren's mean of energies, between the harmonic and the geometric one.
double harmonic_of_roots(double a, double b) {
    const double sum = std::sqrt(a) + std::sqrt(b);
    return sum > 0.0 ? 4.0 * a * b / (sum * sum) : 0.0;
}

double cubic_over_square(double a, double b) {
    const double squares = a * a + b * b;
    return squares > 0.0 ? (a * a * a + b * b * b) / squares : 0.0;
}

double sixth_root(double x) { return std::pow(x, 1.0 / 6.0); }

void require(bool holds, const char* expected) {
    if (!holds) throw std::invalid_argument(expected);
}

// ½ e_ij (γ_i/e_i + γ_j/e_j). A species without drag adds nothing, whatever its energy.
double drag_by_energy(double energy, const Mixed& i, const Mixed& j) {
    const auto share = [&](const Mixed& own) {
        if (own.drag == 0.0) return 0.0;
        require(own.energy > 0.0,
                "the drag divides by both energies, so a species with drag needs an energy above zero");
        return own.drag / own.energy;
    };
    return 0.5 * energy * (share(i) + share(j));
}

}  // namespace

MixingRule find_mixing_rule(std::string_view name) {
    std::string word(name);
    for (char& letter : word) {
        letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
        if (letter == '_' || letter == ' ') letter = '-';
    }
    constexpr std::array<std::pair<std::string_view, MixingRule>, 9> others{{
        {"lore", MixingRule::lorentz_berthelot},
        {"fend", MixingRule::fender_halsey},
        {"hoge", MixingRule::hogervorst},
        {"halg", MixingRule::halgren},
        {"wald", MixingRule::waldman_hagler},
        {"tang", MixingRule::tang_toennies},
        {"func", MixingRule::functional},
        {"fender-hasley", MixingRule::fender_halsey},
        {"tang-tonnies", MixingRule::tang_toennies},
    }};
    for (std::size_t k = 0; k < mixing_rule_names.size(); ++k) {
        if (word == mixing_rule_names[k]) return static_cast<MixingRule>(k);
    }
    for (const auto& [spelling, rule] : others) {
        if (word == spelling) return rule;
    }
    std::string known;
    for (const std::string_view rule : mixing_rule_names) known += (known.empty() ? "" : ", ") + std::string(rule);
    throw std::invalid_argument("unknown mixing rule '" + std::string(name) + "'; known are " + known);
}

Mixed lorentz_berthelot(const Mixed& i, const Mixed& j) {
    return {geometric(i.energy, j.energy), 0.5 * (i.length + j.length), geometric(i.drag, j.drag)};
}

Mixed fender_halsey(const Mixed& i, const Mixed& j) {
    return {harmonic(i.energy, j.energy), 0.5 * (i.length + j.length), harmonic(i.drag, j.drag)};
}

Mixed hogervorst(const Mixed& i, const Mixed& j) {
    return {geometric(i.energy, j.energy), geometric(i.length, j.length), geometric(i.drag, j.drag)};
}

Mixed halgren(const Mixed& i, const Mixed& j) {
    return {harmonic_of_roots(i.energy, j.energy), cubic_over_square(i.length, j.length),
            harmonic_of_roots(i.drag, j.drag)};
}

Mixed waldman_hagler(const Mixed& i, const Mixed& j) {
    const double mean = 0.5 * (sixth_power(i.length) + sixth_power(j.length));
    require(mean > 0.0, "the rule divides by the lengths, so they must not both be zero");
    const double product = i.length * j.length;
    const double ratio = product * product * product / mean;
    return {geometric(i.energy, j.energy) * ratio, sixth_root(mean), geometric(i.drag, j.drag) * ratio};
}

Mixed tang_toennies(const Mixed& i, const Mixed& j) {
    require(i.energy > 0.0 && j.energy > 0.0 && i.length > 0.0 && j.length > 0.0,
            "the rule divides by both energies and both lengths, so all must be above zero");
    const double dispersion = geometric(i.energy * sixth_power(i.length), j.energy * sixth_power(j.length));
    const auto root = [](const Mixed& own) {
        const double sixth = sixth_power(own.length);
        return std::pow(own.energy * sixth * sixth, 1.0 / 13.0);
    };
    const double energy = dispersion * dispersion / std::pow(0.5 * (root(i) + root(j)), 13.0);
    return {energy, sixth_root(dispersion / energy), drag_by_energy(energy, i, j)};
}

Mixed functional(const Mixed& i, const Mixed& j) {
    require(i.length > 0.0 && j.length > 0.0, "the rule divides by both lengths, so they must be above zero");
    const double product = i.length * j.length;
    const double cubes = i.length * i.length * i.length + j.length * j.length * j.length;
    double term = 0.25 * cubes * cubes;
    double lengths = 0.0;
    double sixths = 0.0;
    for (int power = 0; power <= 2; ++power, term /= product) {
        const double length = std::pow(term, 1.0 / (6.0 - 2.0 * power));
        lengths += length;
        sixths += sixth_power(length);
    }
    const double energy = 3.0 * geometric(i.energy, j.energy) * product * product * product / sixths;
    return {energy, lengths / 3.0, drag_by_energy(energy, i, j)};
}

Mixed mix(MixingRule rule, const Mixed& i, const Mixed& j) {
    for (const Mixed& own : {i, j}) {
        require(own.energy >= 0.0 && own.length >= 0.0, "energies and lengths must not be negative");
        require(std::isfinite(own.drag) && own.drag >= 0.0, "drags must be finite and not negative");
    }
    switch (rule) {
        case MixingRule::lorentz_berthelot:
            return lorentz_berthelot(i, j);
        case MixingRule::fender_halsey:
            return fender_halsey(i, j);
        case MixingRule::hogervorst:
            return hogervorst(i, j);
        case MixingRule::halgren:
            return halgren(i, j);
        case MixingRule::waldman_hagler:
            return waldman_hagler(i, j);
        case MixingRule::tang_toennies:
            return tang_toennies(i, j);
        case MixingRule::functional:
            return functional(i, j);
    }
    throw std::invalid_argument("unknown mixing rule");
}

double mix_length(MixingRule rule, double length_i, double length_j, const Mixed& i, const Mixed& j,
                  const Mixed& mixed) {
    switch (rule) {
        case MixingRule::lorentz_berthelot:
        case MixingRule::fender_halsey:
            return 0.5 * (length_i + length_j);
        case MixingRule::hogervorst:
            require(length_i >= 0.0 && length_j >= 0.0, "the rule has no mean of negative lengths");
            return geometric(length_i, length_j);
        case MixingRule::halgren:
            return cubic_over_square(length_i, length_j);
        case MixingRule::waldman_hagler:
            require(length_i >= 0.0 && length_j >= 0.0, "the rule has no mean of negative lengths");
            return sixth_root(0.5 * (sixth_power(length_i) + sixth_power(length_j)));
        case MixingRule::tang_toennies:
        case MixingRule::functional:
            return 0.5 * mixed.length * (length_i / i.length + length_j / j.length);
    }
    throw std::invalid_argument("unknown mixing rule");
}

namespace {

// Parameters as eps, sig and, for some laws, a third number.
struct Form {
    Mixed main;
    double third = 0.0;
};

bool holds_a_and_b(std::string_view key) { return key == "12-6" || key == "m126"; }

Form to_form(std::string_view key, std::span<const double> parameters, double drag) {
    Form form{{parameters[0], parameters[1], drag}, parameters.size() > 2 ? parameters[2] : 0.0};
    if (holds_a_and_b(key)) {
        const double a = parameters[0];
        const double b = parameters[1];
        const bool nothing = a == 0.0 && b == 0.0;
        require(nothing || (a > 0.0 && b > 0.0), "A and B have an eps and a sig only when both are above zero");
        form.main.energy = nothing ? 0.0 : b * b / (4.0 * a);
        form.main.length = nothing ? 0.0 : sixth_root(a / b);
    } else if (key == "wca") {
        form.main.length = std::abs(parameters[1]);  // the readings of sig and D that the law itself has
        form.third = std::min(parameters[2], 0.5 * form.main.length);
    } else if (key == "mdpd") {
        form.main.energy = std::abs(parameters[0]);  // of both, with one sign
        form.main.length = parameters[4];
        form.third = parameters[5];
    }
    return form;
}

MixedPair mix_forms(MixingRule rule, std::string_view key, const Form& i, const Form& j, std::size_t count) {
    const Mixed mixed = mix(rule, i.main, j.main);
    MixedPair pair{{mixed.energy, mixed.length}, mixed.drag};
    if (holds_a_and_b(key)) {
        const double sixth = sixth_power(mixed.length);
        pair.parameters = {4.0 * mixed.energy * sixth * sixth, 4.0 * mixed.energy * sixth};
    }
    if (key == "ljc") {
        require(i.third >= 0.0 && j.third >= 0.0, "c must not be negative");
        pair.parameters.push_back(geometric(i.third, j.third));
    } else if (count > 2) {
        pair.parameters.push_back(mix_length(rule, i.third, j.third, i.main, j.main, mixed));
    }
    return pair;
}

// A, rc and rd of many-body DPD are mixed. B and n must be equal already; m belongs to the species and stays with them,
// as does an rd that both have: a mean that depends on rc would move it.
MixedPair mix_many_body(MixingRule rule, std::span<const double> i, std::span<const double> j, double drag_i,
                        double drag_j) {
    require((i[0] >= 0.0 && j[0] >= 0.0) || (i[0] <= 0.0 && j[0] <= 0.0), "no mean of an attraction and a repulsion");
    require(i[1] == j[1], "B is one number for all pairs");
    require(i[2] == j[2], "no mean of two exponents n");
    const Form first = to_form("mdpd", i, drag_i);
    const Form second = to_form("mdpd", j, drag_j);
    const Mixed mixed = mix(rule, first.main, second.main);
    const double density_range =
        i[5] == j[5] ? i[5] : mix_length(rule, first.third, second.third, first.main, second.main, mixed);
    const double sign = i[0] < 0.0 || j[0] < 0.0 ? -1.0 : 1.0;
    return {{sign * mixed.energy, i[1], i[2], i[3] == j[3] ? i[3] : 0.0, mixed.length, density_range}, mixed.drag};
}

}  // namespace

MixedPair mix(MixingRule rule, std::string_view key, std::span<const double> parameters_i,
              std::span<const double> parameters_j, double drag_i, double drag_j) {
    MixedPair pair{};
    visit(key, [&]<class Law>() {
        if constexpr (Law::info.mixable) {
            constexpr double any_cutoff = 1e30;  // the law's own checks of its numbers, none of them against a cutoff
            static_cast<void>(Law(parameters_i, any_cutoff));
            static_cast<void>(Law(parameters_j, any_cutoff));
            try {
                pair = key == "mdpd" ? mix_many_body(rule, parameters_i, parameters_j, drag_i, drag_j)
                                     : mix_forms(rule, key, to_form(key, parameters_i, drag_i),
                                                 to_form(key, parameters_j, drag_j), Law::info.parameter_names.size());
            } catch (const std::invalid_argument& reason) {
                throw std::invalid_argument(
                    "mixing rule " + std::string(mixing_rule_names[static_cast<std::size_t>(rule)]) + " for pair law " +
                    std::string(key) + ": " + reason.what() + "; give this pair its own line");
            }
        } else {
            throw std::invalid_argument("pair law " + std::string(key) +
                                        " cannot be mixed; give this pair its own line");
        }
    });
    return pair;
}

}  // namespace dlpoly::pair
