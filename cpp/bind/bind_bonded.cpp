// Bonded laws and terms for Python: what there is, single evaluations, the terms of a scene.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bind/bind.hpp"
#include "bonded/bonded_forces.hpp"
#include "bonded/registry.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

using dlpoly::bonded::Kind;
using dlpoly::bonded::LawInfo;
using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;
using BeadArray = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

Kind kind_of(const std::string& name) {
    for (std::size_t k = 0; k < bonded::kinds; ++k) {
        if (bonded::kind_names[k] == name) return static_cast<Kind>(k);
    }
    throw std::invalid_argument("unknown kind of bonded terms '" + name + "'");
}

py::dict describe(const LawInfo& info) {
    std::vector<std::string> names;
    for (const std::string_view name : info.parameter_names) names.emplace_back(name);
    py::dict entry;
    entry["kind"] = std::string(bonded::name(info.kind));
    entry["key"] = std::string(info.key);
    entry["restraint_key"] = std::string(info.restraint_key);
    entry["description"] = std::string(info.description);
    entry["parameter_names"] = names;
    entry["energy_mask"] = info.energy_mask;
    entry["degree_mask"] = info.degree_mask;
    entry["optional"] = info.optional;
    entry["table"] = info.table;
    return entry;
}

py::typing::List<py::typing::Dict<py::str, py::object>> bonded_laws() {
    py::typing::List<py::typing::Dict<py::str, py::object>> laws;
    bonded::for_each_law([&]<class Law>() { laws.append(describe(Law::info)); });
    return laws;
}

// Coordinates one a row: a length or an angle, for angles the angle and both distances. Returns energies and slopes.
std::pair<DoubleArray, DoubleArray> evaluate_bonded(const std::string& kind, const std::string& key,
                                                    const std::vector<double>& parameters,
                                                    const DoubleArray& coordinates) {
    const Kind of = kind_of(kind);
    const py::ssize_t width = of == Kind::angle ? 3 : 1;
    if (coordinates.ndim() != 2 || coordinates.shape(1) != width) {
        throw std::invalid_argument("coordinates of this kind must have shape (n, " + std::to_string(width) + ")");
    }
    const py::ssize_t rows = coordinates.shape(0);
    DoubleArray energies(rows);
    DoubleArray slopes({rows, width});
    const auto at = coordinates.unchecked<2>();
    auto energy = energies.mutable_unchecked<1>();
    auto slope = slopes.mutable_unchecked<2>();
    bonded::visit(of, key, [&]<class Law>() {
        const Law law(parameters);
        for (py::ssize_t row = 0; row < rows; ++row) {
            if constexpr (Law::info.kind == Kind::angle) {
                const bonded::AngleValue value = law(at(row, 0), at(row, 1), at(row, 2));
                energy(row) = value.energy;
                slope(row, 0) = value.by_angle;
                slope(row, 1) = value.by_first;
                slope(row, 2) = value.by_second;
            } else {
                const bonded::Value value = law(at(row, 0));
                energy(row) = value.energy;
                slope(row, 0) = value.slope;
            }
        }
    });
    return {energies, slopes};
}

void add_terms(BondedForces& terms, const std::string& kind, const std::string& key,
               const std::vector<double>& parameters, const BeadArray& beads) {
    const Kind of = kind_of(kind);
    if (beads.ndim() != 2 || beads.shape(1) != static_cast<py::ssize_t>(bonded::beads_of_kind[bonded::index(of)])) {
        throw std::invalid_argument("the beads of a " + kind + " must have one term a row");
    }
    terms.add(of, key, parameters, std::span(beads.data(), static_cast<std::size_t>(beads.size())));
}

}  // namespace

void bind_bonded(py::module_& m) {
    m.def("bonded_laws", &bonded_laws,
          "Every bonded law: kind, keys, parameter names and what the scene must know about it.");
    m.def(
        "evaluate_bonded", &evaluate_bonded, py::arg("kind"), py::arg("key"), py::arg("parameters"),
        py::arg("coordinates"),
        "Energies (n,) and derivatives (n, k) of a law at the coordinates (n, k): a length or an angle, or for angles\n"
        "the angle and both distances from the vertex. Angles in radians. Raises ValueError naming a bad parameter.");

    py::class_<BondedForces>(m, "BondedTerms", "The bonded terms of one System.")
        .def(py::init([](const std::vector<bool>& frozen, double thermal_energy) {
                 return BondedForces(std::vector<std::uint8_t>(frozen.begin(), frozen.end()), thermal_energy);
             }),
             py::arg("frozen"), py::arg("thermal_energy"))
        .def("add", &add_terms, py::arg("kind"), py::arg("key"), py::arg("parameters"), py::arg("beads"),
             "Adds terms of one law and one set of parameters; beads has one term a row, ids counted from 0.")
        .def("set_anchors", &BondedForces::set_anchors, py::arg("positions"), "Where tethers hold their beads, (N, 3).")
        .def("add_scaled_pair", &BondedForces::add_scaled_pair, py::arg("i"), py::arg("j"), py::arg("scale"),
             "A pair that feels its pair law times a factor, without drag and noise.");
}

}  // namespace dlpoly::bind
