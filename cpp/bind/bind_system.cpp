// The simulation object: checks arguments, drops the GIL, calls the core.
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
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
#include "bind/pair_table_builder.hpp"
#include "bind/require.hpp"
#include "core/threads.hpp"
#include "external/hard_walls.hpp"
#include "external/magnetic_field.hpp"
#include "external/soft_walls.hpp"
#include "integrate/equilibration.hpp"
#include "integrate/nose_hoover.hpp"
#include "integrate/piston.hpp"
#include "integrate/system.hpp"
#include "observe/configurational.hpp"
#include "observe/kinetic.hpp"
#include "observe/stress_profile.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

Particles make_particles(Array3N position, Array3N velocity, std::vector<double> mass,
                         std::vector<std::int32_t> species, std::vector<bool> frozen, std::int32_t species_count) {
    const auto beads = static_cast<std::size_t>(position.rows());
    require(
        velocity.rows() == position.rows() && mass.size() == beads && species.size() == beads && frozen.size() == beads,
        "positions, velocities, mass, species and frozen must describe the same number of beads");
    require(position.allFinite() && velocity.allFinite(), "positions and velocities must be finite");
    Particles particles;
    particles.position = std::move(position);
    particles.velocity = std::move(velocity);
    particles.force = Array3N::Zero(particles.position.rows(), 3);
    particles.image = Image3N::Zero(particles.position.rows(), 3);
    particles.mass = std::move(mass);
    particles.species = std::move(species);
    particles.frozen.reserve(beads);
    for (std::size_t i = 0; i < beads; ++i) {
        require(frozen[i] || (particles.mass[i] > 0.0 && std::isfinite(particles.mass[i])),
                "every bead that can move needs a mass larger than 0");
        require(particles.species[i] >= 0 && particles.species[i] < species_count, "a species index is out of range");
        particles.frozen.push_back(frozen[i] ? 1 : 0);
        if (frozen[i]) {
            particles.velocity.row(static_cast<Eigen::Index>(i)).setZero();
        }
    }
    return particles;
}

// Whether there is one finite number above a bound for every bead.
bool fits(const System& system, const std::vector<double>& values, double bound) {
    return values.size() == system.state.particles.mass.size() &&
           std::ranges::all_of(values, [bound](double value) { return std::isfinite(value) && value > bound; });
}

System make_system(const Matrix3& cell, std::array<bool, 3> periodic, Array3N positions, Array3N velocities,
                   std::vector<double> mass, std::vector<std::int32_t> species, std::vector<bool> frozen,
                   PairTableBuilder& pairs, const StepSettings& settings) {
    require(settings.timestep > 0.0 && std::isfinite(settings.timestep), "the timestep must be larger than 0");
    require(settings.thermal_energy >= 0.0, "the thermal energy must not be negative");
    PairTable table = pairs.take();
    State state{Box(cell, periodic),
                make_particles(std::move(positions), std::move(velocities), std::move(mass), std::move(species),
                               std::move(frozen), table.species()),
                0,
                0.0,
                {}};
    for (Eigen::Index i = 0; i < state.particles.count(); ++i) {
        Vector3 position = state.particles.position.row(i).transpose();
        require(state.box.wrap(position, state.particles.image.row(i).data()),
                "a position is too far outside the cell");
        state.particles.position.row(i) = position.transpose();
    }
    state.particles.image.setZero();
    PairForces pair_forces(std::move(table), settings.thermal_energy, settings.timestep);
    return System(std::move(state), Forces(std::move(pair_forces)), settings);
}

py::array_t<std::int64_t> distance_counts(const System& system) {
    require(system.distances.has_value(), "pair distances are not sampled in this system");
    const std::vector<std::int64_t>& counts = system.distances->counts();
    return py::array_t<std::int64_t>(static_cast<py::ssize_t>(counts.size()), counts.data());
}

using Numbers = py::array_t<double>;
using Counts = py::array_t<std::int64_t>;

std::tuple<Numbers, Numbers, Numbers, Counts> profile_of(System& system, int axis, std::int32_t layers) {
    StressProfile profile;
    {
        const py::gil_scoped_release release;
        profile = stress_profile(system.state, system.forces, axis, layers);
    }
    const auto rows = static_cast<py::ssize_t>(layers);
    const auto tensors = [&](const std::vector<double>& values) {
        return Numbers({rows, py::ssize_t{6}}, values.data());
    };
    const auto species = static_cast<py::ssize_t>(system.forces.pairs().table().species());
    return {tensors(profile.kinetic), tensors(profile.conservative), tensors(profile.bonded),
            Counts({rows, species}, profile.beads.data())};
}

// (height, exponent, range, push) of two species, see cpp/meso/many_body.hpp.
using DensityNumbers = std::array<double, 4>;

void set_many_body(System& system, const std::string& kernel, double strength, std::vector<double> powers,
                   const std::vector<std::tuple<std::int32_t, std::int32_t, DensityNumbers>>& pairs) {
    const PairTable& table = system.forces.pairs().table();
    require(kernel == "power" || kernel == "lucy", "the kernel of local densities is power or lucy");
    require(powers.size() == static_cast<std::size_t>(table.species()), "local densities need one power a species");
    ManyBodySettings settings;
    settings.kernel = kernel == "lucy" ? DensityKernel::lucy : DensityKernel::power;
    settings.strength = strength;
    settings.powers = std::move(powers);
    settings.pairs.resize(table.terms());
    for (const auto& [a, b, numbers] : pairs) {
        require(a >= 0 && b >= 0 && a < table.species() && b < table.species(), "a species index is out of range");
        for (const std::uint32_t term : {table.term(a, b), table.term(b, a)}) {
            require(numbers[2] * numbers[2] <= table.reach_squared()[term], "local densities reach beyond a pair law");
            settings.pairs[term] = {numbers[0], numbers[1], numbers[2], numbers[3]};
        }
    }
    system.set_many_body(std::make_shared<ManyBody>(std::move(settings)));
}

Numbers local_densities(const System& system) {
    require(system.many_body != nullptr, "this system has no local densities: no pair has the law mdpd");
    const std::vector<double> values = system.many_body->local_densities();
    return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace

void bind_system(py::module_& m) {
    m.def("set_threads", &set_threads, py::arg("threads"), "Number of threads of the next parallel regions.");
    m.def("thread_limit", &thread_limit, "Number of threads that would be used now.");
    m.def("has_threads", &has_threads, "Whether the core was built with OpenMP.");

    py::class_<System>(m, "System", "State, forces and integrator of one simulation.")
        .def(py::init(&make_system), py::arg("cell"), py::arg("periodic"), py::arg("positions"), py::arg("velocities"),
             py::arg("mass"), py::arg("species"), py::arg("frozen"), py::arg("pairs"), py::arg("settings"))
        .def(
            "add_external_field",
            [](System& s, const std::string& key, const std::vector<double>& parameters, std::vector<double> charges) {
                require(charges.empty() || charges.size() == s.state.particles.mass.size(),
                        "there must be one charge a bead");
                if (key == "magn") {
                    require(parameters.size() >= 3, "the external field magn needs three numbers: Hx Hy Hz");
                    require(!charges.empty(), "the external field magn needs the charges of the beads");
                    s.set_flight(std::make_shared<MagneticField>(Vector3(parameters[0], parameters[1], parameters[2]),
                                                                 std::move(charges)));
                    return;
                }
                s.add_field(make_external_field(key, parameters, std::move(charges)));
            },
            py::arg("key"), py::arg("parameters"), py::arg("charges") = std::vector<double>())
        .def(
            "set_walls",
            [](System& s, std::array<bool, 3> walled, const Vector3& distance, bool bounce_back) {
                s.set_flight(std::make_shared<HardWalls>(WallPlanes{walled, distance}, bounce_back));
            },
            py::arg("walled"), py::arg("distance"), py::arg("bounce_back"),
            "Hard walls across these axes at these distances from the origin on both sides.")
        .def(
            "add_soft_walls",
            [](System& s, std::array<bool, 3> walled, const Vector3& distance, std::vector<double> strengths,
               double range) {
                require(strengths.size() == static_cast<std::size_t>(s.forces.pairs().table().species()),
                        "soft walls need one strength a species");
                s.add_field(std::make_unique<SoftWalls>(WallPlanes{walled, distance}, std::move(strengths), range));
            },
            py::arg("walled"), py::arg("distance"), py::arg("strengths"), py::arg("reach"),
            "A soft repulsion before the walls; see cpp/external/soft_walls.hpp.")
        .def(
            "set_bonded",
            [](System& s, BondedForces& terms, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& excluded) {
                const auto beads = static_cast<std::size_t>(s.state.particles.count());
                require(terms.beads() == beads, "the bonded terms are made for another number of beads");
                s.set_bonded(std::move(terms), Exclusions(beads, excluded));
            },
            py::arg("terms"), py::arg("excluded"),
            "Takes the bonded terms, which are then empty, and the pairs of beads that have no pair forces.")
        .def(
            "set_constraints",
            [](System& s, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& beads,
               const std::vector<double>& lengths, double tolerance, std::int64_t most_iterations) {
                require(beads.size() == lengths.size(), "every constraint needs two beads and a length");
                std::vector<Constraint> constraints;
                for (std::size_t k = 0; k < beads.size(); ++k) {
                    constraints.push_back({beads[k].first, beads[k].second, lengths[k]});
                }
                s.set_constraints(std::move(constraints), tolerance, most_iterations);
            },
            py::arg("beads"), py::arg("lengths"), py::arg("tolerance"), py::arg("most_iterations"),
            "Takes pairs of beads whose distances stay fixed.")
        .def("meet_constraints", &System::meet_constraints, py::call_guard<py::gil_scoped_release>(),
             "Brings positions to the lengths of constraints, and takes out of velocities what would change them.")
        .def(
            "set_charges",
            [](System& s, const std::vector<double>& charges, const ChargeSettings& settings,
               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& excluded,
               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& scaled, const std::vector<double>& scales) {
                require(charges.size() == static_cast<std::size_t>(s.state.particles.count()),
                        "there must be one charge a bead");
                require(scaled.size() == scales.size(), "there must be one factor a scaled pair");
                std::vector<ChargeForces::ScaledPair> pairs;
                for (std::size_t k = 0; k < scaled.size(); ++k) {
                    pairs.push_back({scaled[k].first, scaled[k].second, scales[k]});
                }
                s.set_charges(ChargeForces(charges, s.state.particles.frozen, settings, excluded, pairs));
            },
            py::arg("charges"), py::arg("settings"), py::arg("excluded"), py::arg("scaled"), py::arg("scales"),
            "Adds electrostatics: charges (N,) in e, pairs without it, and pairs that feel it times a factor.")
        .def("set_many_body", &set_many_body, py::arg("kernel"), py::arg("strength"), py::arg("powers"),
             py::arg("pairs"),
             "Adds many-body DPD: one power m a species, and (a, b, (W(0), n, r_d, push)) of pairs of species.")
        .def("local_densities", &local_densities, "Local densities (N,) at the last evaluation of forces.")
        .def("initialise", &System::initialise, py::call_guard<py::gil_scoped_release>(),
             "Computes and observes the forces of the present state.")
        .def("plan", &System::plan, "How steps are computed: the fast path, or the general one and why.")
        .def("run", &System::run, py::arg("steps"), py::call_guard<py::gil_scoped_release>(),
             "Takes steps and observes the last one.")
        .def(
            "draw_velocities",
            [](System& s, bool zero_momentum) {
                draw_velocities(s.state, s.settings, Stream::start_velocities, zero_momentum, s.forces.constraints());
                s.ready = false;
            },
            py::arg("zero_momentum"))
        .def("rescale_velocities",
             [](System& s) {
                 rescale_velocities(s.state.particles, s.settings);
                 s.ready = false;
             })
        .def("remove_drift",
             [](System& s) {
                 remove_drift(s.state.particles, s.settings.shear_rate);
                 s.ready = false;
             })
        .def("set_cell_width", &System::set_cell_width, py::arg("width"),
             "Link cells of at least this width instead of one range; never changes results.")
        .def_readwrite("settings", &System::settings)
        .def_readwrite("ready", &System::ready, "Whether the forces belong to the present positions.")
        .def_property(
            "step", [](const System& s) { return s.state.step; },
            [](System& s, std::uint64_t step) { s.state.step = step; })
        .def_property(
            "thermostat", [](const System& s) { return s.state.thermostat; },
            [](System& s, std::vector<double> values) { s.state.thermostat = std::move(values); },
            "Variables that a thermostat or barostat keeps from step to step.")
        .def_property(
            "time", [](const System& s) { return s.state.time; }, [](System& s, double time) { s.state.time = time; })
        .def_property(
            "positions", [](const System& s) { return s.state.particles.position; },
            [](System& s, const Array3N& value) {
                require(value.rows() == s.state.particles.count() && value.allFinite(),
                        "positions must be finite and of shape (N, 3)");
                s.state.particles.position = value;
                s.ready = false;
            })
        .def_property(
            "velocities", [](const System& s) { return s.state.particles.velocity; },
            [](System& s, const Array3N& value) {
                require(value.rows() == s.state.particles.count() && value.allFinite(),
                        "velocities must be finite and of shape (N, 3)");
                s.state.particles.velocity = value;
            })
        .def_property(
            "forces", [](const System& s) { return s.state.particles.force; },
            [](System& s, const Array3N& value) {
                require(value.rows() == s.state.particles.count() && value.allFinite(),
                        "forces must be finite and of shape (N, 3)");
                s.state.particles.force = value;
            })
        .def_property(
            "images", [](const System& s) { return s.state.particles.image; },
            [](System& s, const Image3N& value) {
                require(value.rows() == s.state.particles.count(), "images must be of shape (N, 3)");
                s.state.particles.image = value;
            })
        .def_property(
            "bead_temperatures", [](const System& s) { return s.state.particles.temperature; },
            [](System& s, std::vector<double> values) {
                require(values.empty() || fits(s, values, 0.0), "temperatures must be finite, above 0 and one a bead");
                s.state.particles.temperature = std::move(values);
                s.ready = false;
            },
            "Internal temperatures (N,) as k_B T; empty: beads have none.")
        .def_property(
            "heat_capacities", [](const System& s) { return s.state.particles.heat_capacity; },
            [](System& s, std::vector<double> values) {
                require(values.empty() || fits(s, values, 0.0), "heat capacities must be finite, above 0, one a bead");
                s.state.particles.heat_capacity = std::move(values);
            },
            "C_v/k_B of the beads (N,); empty: beads have none.")
        .def_property(
            "concentrations", [](const System& s) { return s.state.particles.concentration; },
            [](System& s, const ArrayXN& values) {
                require(values.size() == 0 || (values.rows() == s.state.particles.count() && values.allFinite() &&
                                               values.minCoeff() >= 0.0),
                        "concentrations must be finite, not negative and of shape (N, species)");
                s.state.particles.concentration = values;
            },
            "Of dissolved species in the beads, (N, species); empty: beads carry none.")
        .def(
            "exchange",
            [](System& s, std::vector<double> temperatures, const ArrayXN& concentrations) {
                auto& beads = s.state.particles;
                require(temperatures.size() == beads.temperature.size() &&
                            (temperatures.empty() || fits(s, temperatures, 0.0)),
                        "temperatures must be finite, above 0 and as many as there are");
                require(concentrations.rows() == beads.concentration.rows() &&
                            concentrations.cols() == beads.concentration.cols() && concentrations.allFinite() &&
                            (concentrations.size() == 0 || concentrations.minCoeff() >= 0.0),
                        "concentrations must be finite, not negative and shaped as they are");
                beads.temperature = std::move(temperatures);
                beads.concentration = concentrations;
            },
            py::arg("temperatures"), py::arg("concentrations"),
            "Replace what beads carry between two steps, as a process does: forces stay those of the last step.")
        .def(
            "wrap",
            [](System& s) {
                for (Eigen::Index i = 0; i < s.state.particles.count(); ++i) {
                    Vector3 position = s.state.particles.position.row(i).transpose();
                    require(s.state.box.wrap(position, s.state.particles.image.row(i).data()),
                            "a position is too far outside the cell");
                    s.state.particles.position.row(i) = position.transpose();
                }
                s.ready = false;
            },
            "Brings positions that were set back into the cell, counting the cells they cross.")
        .def_property(
            "cell", [](const System& s) { return s.state.box.cell(); },
            [](System& s, const Matrix3& cell) {
                s.state.box = Box(cell, s.state.box.periodic());
                s.ready = false;
            },
            "Cell vectors by row. Setting them leaves the positions as they are.")
        .def_property_readonly("volume", [](const System& s) { return s.state.box.volume(); })
        .def_property_readonly("pair_energy", [](const System& s) { return s.totals.energy; })
        .def_property_readonly("conservative_virial_tensor", [](const System& s) { return s.totals.conservative; })
        .def_property_readonly("drag_virial_tensor", [](const System& s) { return s.totals.drag; })
        .def_property_readonly("noise_virial_tensor", [](const System& s) { return s.totals.noise; })
        .def_property_readonly(
            "bonded_energies",
            [](const System& s) {
                const std::array<double, bonded::components>& energy = s.forces.bonded_totals().energy;
                return std::vector<double>(energy.begin(), energy.begin() + bonded::kinds);
            },
            "Energies of bonds, angles, dihedrals, inversions and tethers.")
        .def_property_readonly(
            "bonded_virial_tensors",
            [](const System& s) {
                const std::array<Matrix3, bonded::components>& virial = s.forces.bonded_totals().virial;
                return std::vector<Matrix3>(virial.begin(), virial.begin() + bonded::kinds);
            },
            "Σ F_a r_b of bonds, angles, dihedrals, inversions and tethers.")
        .def_property_readonly("charge_energy", [](const System& s) { return s.forces.charge_totals().energy; })
        .def_property_readonly(
            "charge_virial_tensor", [](const System& s) { return s.forces.charge_totals().virial; },
            "Σ F_a r_b of the electrostatics.")
        .def_property_readonly(
            "constraint_virial_tensor",
            [](const System& s) -> Matrix3 {
                const Constraints* constraints = s.forces.constraints();
                return constraints == nullptr ? Matrix3::Zero() : constraints->virial(s.state.box, s.state.particles);
            },
            "Σ F_a r_b of the forces that hold the lengths of constraints, at the present forces and velocities.")
        .def_property_readonly(
            "constraint_deviation",
            [](const System& s) {
                const Constraints* constraints = s.forces.constraints();
                return constraints == nullptr ? 0.0 : constraints->deviation(s.state.box, s.state.particles);
            },
            "Largest difference between a constrained distance and its length.")
        .def_property_readonly(
            "kinetic_tensor",
            [](const System& s) {
                return s.totals.kinetic ? *s.totals.kinetic : kinetic_tensor(s.state.particles, s.settings.shear_rate);
            },
            "Σ m v_a v_b, of velocities relative to the flow in a sheared cell.")
        .def(
            "configurational",
            [](System& s) {
                const Configurational found = configurational(s.state, s.forces);
                return std::pair<double, double>{found.squared_force, found.curvature};
            },
            py::call_guard<py::gil_scoped_release>(), "Σ|∇U|² and Σ∇²U over the mobile beads at the present positions.")
        .def("stress_profile", &profile_of, py::arg("axis"), py::arg("layers"),
             "Σ m v_a v_b, Σ F_a r_b of pairs and of bonded terms, (layers, 6) each, and beads (layers, species).")
        .def_property_readonly(
            "thermostat_energy",
            [](const System& s) {
                return thermostat_energy(s.state, s.settings) + barostat_energy(s.state, s.settings);
            },
            "What a Nosé–Hoover thermostat adds to the conserved energy, or a piston to the energy: its own and P V.")
        .def_property_readonly("field_energy", [](const System& s) { return s.forces.field_energy(); })
        .def_property_readonly("momentum",
                               [](const System& s) { return momentum(s.state.particles, s.settings.shear_rate); })
        .def_property_readonly("cell_counts", [](System& s) { return s.forces.pairs().cells().counts(); })
        .def("enable_distances", &System::enable_distances, py::arg("reach"), py::arg("bins"), py::arg("every"),
             py::arg("after") = 0)
        .def("distance_counts", &distance_counts)
        .def(
            "sample_distances",
            [](System& s) {
                require(s.distances.has_value(), "pair distances are not sampled in this system");
                s.distances->sample(s.state.box, s.state.particles);
            },
            "Counts the pair distances of the present positions as one more sample, whatever the step.")
        .def_property_readonly("distance_samples",
                               [](const System& s) { return s.distances ? s.distances->samples() : 0; })
        .def_property_readonly(
            "distance_volumes", [](const System& s) { return s.distances ? s.distances->volumes() : 0.0; },
            "Sum of the cell's volumes over the samples.")
        .def(
            "restore_distances",
            [](System& s, std::vector<std::int64_t> counts, std::int64_t samples, double volumes) {
                require(s.distances.has_value(), "pair distances are not sampled in this system");
                s.distances->restore(std::move(counts), samples, volumes);
            },
            py::arg("counts"), py::arg("samples"), py::arg("volumes"));
}

}  // namespace dlpoly::bind
