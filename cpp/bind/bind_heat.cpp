// Heat that beads carry: coefficients by pair of species, and what a system is told about them.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bind/bind.hpp"
#include "bind/require.hpp"
#include "integrate/system.hpp"
#include "meso/heat_exchange.hpp"
#include "meso/heat_forces.hpp"
#include "meso/heat_pairs.hpp"
#include "meso/heat_sources.hpp"
#include "meso/viscous_heating.hpp"
#include "observe/kinetic.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

using Polynomial = HeatPair::Polynomial;
using GivenSource = std::tuple<std::string, std::vector<double>, double>;

HeatSource make_source(const GivenSource& given) {
    const auto& [kind, numbers, rate] = given;
    require(std::isfinite(rate), "the rate of a heat source must be finite");
    if (kind == "box") {
        require(numbers.size() == 6, "a box has six numbers");
        return {HeatBox{{numbers[0], numbers[2], numbers[4]}, {numbers[1], numbers[3], numbers[5]}}, rate};
    }
    if (kind == "sphere") {
        require(numbers.size() == 4, "a sphere has four numbers");
        return {HeatSphere{Vector3(numbers[0], numbers[1], numbers[2]), numbers[3]}, rate};
    }
    require(kind == "species" && numbers.size() == 1, "a heat source is a box, a sphere or a species");
    return {HeatSpecies{static_cast<std::int32_t>(numbers[0])}, rate};
}

void set_heat(System& system, const HeatPairs& given, bool conserving, const std::vector<GivenSource>& sources) {
    const std::size_t beads = system.state.particles.mass.size();
    const auto species = static_cast<std::size_t>(system.forces.pairs().table().species());
    require(!system.settings.heat, "the system has heat already");
    require(given.held.size() == beads, "there must be one switch a bead that says whether its temperature is held");
    require(given.all().size() == species * species, "the coefficients are for another number of species");
    require(system.state.particles.temperature.size() == beads && system.state.particles.heat_capacity.size() == beads,
            "beads need temperatures and heat capacities before coefficients");
    const auto pairs = std::make_shared<const HeatPairs>(given);
    system.settings.heat = pairs;
    const bool forces = system.settings.order == Order::velocity_verlet && system.settings.drag;
    if (forces || pairs->scaled_repulsion) {
        system.add_modifier(std::make_shared<HeatForces>(pairs));
    }
    if (forces) {
        using Form = ViscousHeating::Form;
        system.add_process(std::make_unique<ViscousHeating>(pairs, conserving ? Form::conserving : Form::lammps));
    }
    if (std::ranges::any_of(pairs->all(), [](const HeatPair& pair) { return pair.conductivity > 0.0; })) {
        system.add_process(std::make_unique<HeatExchange>(system.forces.pairs().table(), pairs));
    }
    if (!sources.empty()) {
        std::vector<HeatSource> made;
        for (const GivenSource& source : sources) {
            made.push_back(make_source(source));
        }
        system.add_process(std::make_unique<HeatSources>(std::move(made), pairs));
    }
}

// Σ C T of all beads.
double internal_energy(const System& system) {
    const Particles& particles = system.state.particles;
    double sum = 0.0;
    for (std::size_t i = 0; i < particles.temperature.size(); ++i) {
        sum += particles.heat_capacity[i] * particles.temperature[i];
    }
    return sum;
}

}  // namespace

void bind_heat(py::module_& m) {
    py::class_<HeatPairs>(m, "HeatPairs", "Coefficients of beads that carry heat; see cpp/meso/heat_pairs.hpp.")
        .def(py::init([](std::int32_t species, double reference, double weight_exponent) {
                 require(species > 0, "there must be a species");
                 require(reference > 0.0 && std::isfinite(reference), "the reference temperature must be above 0");
                 require(weight_exponent > 0.0, "the exponent of the drag's weight must be above 0");
                 return HeatPairs(species, reference, weight_exponent);
             }),
             py::arg("species"), py::arg("reference"), py::arg("weight_exponent"))
        .def(
            "set",
            [](HeatPairs& pairs, std::int32_t a, std::int32_t b, double conductivity, double reach, double exponent,
               const Polynomial& weight, const Polynomial& conduction, const Polynomial& drag) {
                const auto species =
                    static_cast<std::int32_t>(std::lround(std::sqrt(static_cast<double>(pairs.all().size()))));
                require(a >= 0 && b >= 0 && a < species && b < species, "a species index is out of range");
                require(conductivity >= 0.0 && std::isfinite(conductivity), "the conductivity must not be negative");
                require(conductivity == 0.0 || (reach > 0.0 && exponent > 0.0),
                        "conduction needs a range and an exponent above 0");
                pairs.set(a, b, {conductivity, reach, exponent, weight, conduction, drag});
            },
            py::arg("a"), py::arg("b"), py::arg("conductivity"), py::arg("reach"), py::arg("exponent"),
            py::arg("weight") = Polynomial{}, py::arg("conduction") = Polynomial{}, py::arg("drag") = Polynomial{})
        .def_property(
            "held", [](const HeatPairs& pairs) { return std::vector<bool>(pairs.held.begin(), pairs.held.end()); },
            [](HeatPairs& pairs, const std::vector<bool>& held) { pairs.held.assign(held.begin(), held.end()); },
            "Beads whose temperature stays what it is, (N,).")
        .def_readwrite("scaled_repulsion", &HeatPairs::scaled_repulsion);

    m.def("set_heat", &set_heat, py::arg("system"), py::arg("pairs"), py::arg("conserving"), py::arg("sources"),
          "Gives beads that carry heat their coefficients, once; sources: "
          "(box, sphere or species, numbers, rate).");
    m.def("internal_energy", &internal_energy, py::arg("system"),
          "Sum of heat capacity times temperature of all beads.");
    m.def(
        "present_kinetic_energy",
        [](const System& system) { return 0.5 * kinetic_tensor(system.state.particles).trace(); }, py::arg("system"),
        "Of the present velocities, which may not be those that the kinetic stress is made of.");
    m.def(
        "heat_account",
        [](const System& system) { return std::pair(system.state.heat_supplied, system.state.heat_ahead); },
        py::arg("system"),
        "What sources and held beads gave since the start, and the work charged ahead; see state.hpp.");
    m.def(
        "set_heat_account",
        [](System& system, double supplied, double ahead) {
            system.state.heat_supplied = supplied;
            system.state.heat_ahead = ahead;
        },
        py::arg("system"), py::arg("supplied"), py::arg("ahead"));
}

}  // namespace dlpoly::bind
