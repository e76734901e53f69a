// Pair laws and mixing rules for Python: what there is, single evaluations, ranges, tails, mixed parameters.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bind/bind.hpp"
#include "pair/mixing.hpp"
#include "pair/registry.hpp"
#include "pair/shift.hpp"
#include "pair/tail.hpp"
#include "sweep/pair_rounds.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

using dlpoly::pair::LawInfo;
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::dict describe(const LawInfo& info) {
    std::vector<std::string> names;
    for (const std::string_view name : info.parameter_names) names.emplace_back(name);
    py::dict entry;
    entry["key"] = std::string(info.key);
    entry["description"] = std::string(info.description);
    entry["parameter_names"] = names;
    entry["energy_mask"] = info.energy_mask;
    entry["drag_slot"] = info.drag_slot;
    entry["soft"] = info.soft;
    entry["has_tail"] = info.has_tail;
    entry["mixable"] = info.mixable;
    entry["shiftable"] = info.shiftable;
    return entry;
}

py::typing::List<py::typing::Dict<py::str, py::object>> pair_laws() {
    py::typing::List<py::typing::Dict<py::str, py::object>> laws;
    dlpoly::pair::for_each_law([&]<class Law>() { laws.append(describe(Law::info)); });
    return laws;
}

std::shared_ptr<const dlpoly::pair::Table> table_from(const std::optional<DoubleArray>& values, double spacing) {
    if (!values) return nullptr;
    if (values->ndim() != 2 || values->shape(1) != 2) {
        throw std::invalid_argument("table must have shape (points, 2), the columns U and G = -r dU/dr");
    }
    auto table = std::make_shared<dlpoly::pair::Table>();
    table->spacing = spacing;
    const auto entries = values->unchecked<2>();
    for (py::ssize_t k = 0; k < entries.shape(0); ++k) {
        table->energy.push_back(entries(k, 0));
        table->virial.push_back(entries(k, 1));
    }
    return table;
}

std::pair<DoubleArray, DoubleArray> evaluate_pair(const std::string& key, const std::vector<double>& parameters,
                                                  double cutoff, const DoubleArray& distances, bool force_shift,
                                                  const std::optional<DoubleArray>& values, double spacing) {
    const auto table = table_from(values, spacing);
    const std::span<const double> distance(distances.data(), static_cast<std::size_t>(distances.size()));
    for (const double r : distance) {
        if (!(std::isfinite(r) && r >= 0.0)) {
            throw std::invalid_argument("distances must be finite and not negative");
        }
    }
    const std::vector<py::ssize_t> shape(distances.shape(), distances.shape() + distances.ndim());
    DoubleArray energy(shape);
    DoubleArray force(shape);
    const std::span<double> energies(energy.mutable_data(), distance.size());
    const std::span<double> forces(force.mutable_data(), distance.size());
    dlpoly::pair::visit(key, [&]<class Law>() {
        const Law law = dlpoly::pair::make<Law>(parameters, cutoff, table);
        const auto shift = force_shift ? dlpoly::pair::shift_of(law, cutoff) : dlpoly::pair::Shift{};
        for (std::size_t k = 0; k < distance.size(); ++k) {
            const double r = distance[k];
            const auto value = r < cutoff ? dlpoly::pair::shifted(law(r * r), shift, r * r) : dlpoly::pair::PairValue{};
            energies[k] = value.energy;
            forces[k] = value.force_over_r * r;
        }
    });
    return {energy, force};
}

double pair_range(const std::string& key, const std::vector<double>& parameters) {
    double range = 0.0;
    dlpoly::pair::visit(key, [&]<class Law>() {
        if constexpr (!std::is_same_v<Law, dlpoly::pair::Tabulated>) {
            // No law's own range depends on the run's cutoff; the largest one satisfies every check against it.
            range = Law(parameters, 1e30).range();
        }
    });
    return range;
}

std::pair<double, double> pair_tail(const std::string& key, const std::vector<double>& parameters, double cutoff) {
    dlpoly::pair::Tail result;
    dlpoly::pair::visit(key, [&]<class Law>() {
        if constexpr (!std::is_same_v<Law, dlpoly::pair::Tabulated>) {
            result = dlpoly::pair::tail(Law(parameters, cutoff), cutoff);
        } else {
            throw std::invalid_argument("pair law tab has no formula: its TABLE file gives the long-range correction");
        }
    });
    return {result.energy, result.virial};
}

std::pair<std::vector<double>, double> mix(const std::string& rule, const std::string& key,
                                           const std::vector<double>& parameters_i,
                                           const std::vector<double>& parameters_j, double drag_i, double drag_j) {
    const auto pair =
        dlpoly::pair::mix(dlpoly::pair::find_mixing_rule(rule), key, parameters_i, parameters_j, drag_i, drag_j);
    return {pair.parameters, pair.drag};
}

std::vector<std::string> mixing_rules() {
    return {dlpoly::pair::mixing_rule_names.begin(), dlpoly::pair::mixing_rule_names.end()};
}

std::pair<std::vector<std::uint32_t>, std::vector<std::uint32_t>> pair_rounds(
    const std::vector<std::uint32_t>& first, const std::vector<std::uint32_t>& second) {
    if (first.size() != second.size()) {
        throw std::invalid_argument("pairs have two beads each");
    }
    PairRows::Row row;
    std::size_t beads = 0;
    row.make_room(first.size());
    row.count = first.size();
    for (std::size_t k = 0; k < first.size(); ++k) {
        row.i[k] = first[k];
        row.j[k] = second[k];
        beads = std::max<std::size_t>({beads, first[k] + std::size_t{1}, second[k] + std::size_t{1}});
    }
    PairRounds rounds;
    rounds.arrange(row, beads);
    return {rounds.place(), rounds.start()};
}

}  // namespace

void bind_pair(py::module_& module) {
    module.def("pair_laws", &pair_laws, "Every pair law: key, parameter names and what the scene must know about it.");
    module.def("evaluate_pair", &evaluate_pair, py::arg("key"), py::arg("parameters"), py::arg("cutoff"),
               py::arg("distances"), py::arg("force_shift") = false, py::arg("table") = py::none(),
               py::arg("spacing") = 0.0,
               "U and -dU/dr (internal units, arrays shaped like distances in Å) of one pair law, zero from the cutoff "
               "on.\n\ntable: (points, 2) array of U and G = -r dU/dr at r = spacing, 2 spacing, ...; only for tab.\n"
               "Raises ValueError for an unknown key and for parameters outside their range.");
    module.def("pair_range", &pair_range, py::arg("key"), py::arg("parameters"),
               "Distance in Å where the law itself ends; 0 when it ends at the run's cutoff.");
    module.def("pair_tail", &pair_tail, py::arg("key"), py::arg("parameters"), py::arg("cutoff"),
               "Integrals of U r^2 dr and of r^3 dU/dr dr beyond the cutoff; (0, 0) for laws that have no such tail.");
    module.def("mix", &mix, py::arg("rule"), py::arg("key"), py::arg("parameters_i"), py::arg("parameters_j"),
               py::arg("drag_i"), py::arg("drag_j"),
               "Parameters and drag of the pair i-j from those of i-i and j-j, which follow the same pair law.\n\n"
               "Raises ValueError for laws that cannot be mixed and for numbers the rule cannot take.");
    module.def("pair_rounds", &pair_rounds, py::arg("first"), py::arg("second"),
               "Pairs of beads in rounds without common beads: each pair's place, and where the rounds start.");
    module.def("mixing_rules", &mixing_rules, "Names of the mixing rules; DL_POLY's spellings are accepted as well.");
}

}  // namespace dlpoly::bind
