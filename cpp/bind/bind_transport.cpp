// Transport of dissolved species: checks arguments and gives it to a system.
#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bind/bind.hpp"
#include "bind/require.hpp"
#include "integrate/system.hpp"
#include "meso/region.hpp"
#include "meso/species_transport.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

// What Python keeps a hold of while a system uses it.
class TransportHandle {
  public:
    TransportHandle(std::int32_t bead_species, std::int32_t dissolved)
        : bead_species_(bead_species), dissolved_(dissolved) {
        require(bead_species > 0 && dissolved > 0, "there must be a bead species and a dissolved one");
        process_ = std::make_shared<SpeciesTransport>(bead_species, dissolved);
    }

    void set_flux(std::int32_t a, std::int32_t b, std::int32_t dissolved, double rate, double range, double exponent,
                  double noise) {
        check(a, dissolved);
        check(b, dissolved);
        require(rate >= 0.0 && std::isfinite(rate) && noise >= 0.0 && std::isfinite(noise),
                "the rate and the noise of a flux must be finite and not negative");
        require(range > 0.0 && std::isfinite(range) && exponent > 0.0 && std::isfinite(exponent),
                "a flux needs a range and an exponent larger than 0");
        process_->exchange().set_flux(a, b, dissolved, {rate, range, exponent, noise});
    }
    void set_noise(const std::string& noise) {
        require(noise == "off" || noise == "sqrt" || noise == "lammps", "the noise is off, sqrt or lammps");
        process_->exchange().set_noise(noise == "sqrt"     ? FluxNoise::root
                                       : noise == "lammps" ? FluxNoise::linear
                                                           : FluxNoise::none);
    }
    void add_source(std::int32_t dissolved, double rate, const std::string& kind, const std::vector<double>& numbers) {
        check(0, dissolved);
        require(std::isfinite(rate), "the rate of a source must be finite");
        process_->add_source(dissolved, rate, region(kind, numbers));
    }
    void add_reaction(double rate, std::vector<std::int32_t> reactants, std::vector<double> change,
                      std::int32_t bead_species) {
        require(rate >= 0.0 && std::isfinite(rate), "the rate of a reaction must be finite and not negative");
        require(change.size() == static_cast<std::size_t>(dissolved_),
                "a reaction needs the change of every dissolved species");
        require(bead_species >= -1 && bead_species < bead_species_, "a bead species is out of range");
        process_->add_reaction(SpeciesReaction(rate, std::move(reactants), std::move(change), bead_species));
    }
    void add_hold(std::int32_t bead_species, std::int32_t dissolved, double value) {
        check(bead_species, dissolved);
        require(value >= 0.0 && std::isfinite(value), "a held concentration must be finite and not negative");
        process_->add_hold(bead_species, dissolved, value);
    }
    void join(System& system) const {
        require(system.forces.pairs().table().species() == bead_species_,
                "the transport is made for another number of bead species");
        system.add_process(std::make_unique<Shared>(process_));
    }
    [[nodiscard]] ArrayXN tally() const { return process_->tally(); }
    void set_tally(const ArrayXN& tally) { process_->set_tally(tally); }

  private:
    class Shared : public BeadProcess {
      public:
        explicit Shared(std::shared_ptr<SpeciesTransport> process) : process_(std::move(process)) {}
        void advance(State& state, Forces& forces, const StepSettings& settings) override {
            process_->advance(state, forces, settings);
        }

      private:
        std::shared_ptr<SpeciesTransport> process_;
    };

    void check(std::int32_t bead_species, std::int32_t dissolved) const {
        require(bead_species >= 0 && bead_species < bead_species_ && dissolved >= 0 && dissolved < dissolved_,
                "a bead species or a dissolved species is out of range");
    }
    [[nodiscard]] Region region(const std::string& kind, const std::vector<double>& n) const {
        if (kind == "box" && n.size() == 6) {
            return Region::box({n[0], n[2], n[4]}, {n[1], n[3], n[5]});
        }
        if (kind == "sphere" && n.size() == 4) {
            return Region::sphere({n[0], n[1], n[2]}, n[3]);
        }
        if (kind == "species" && n.size() == 1) {
            const auto species = static_cast<std::int32_t>(n[0]);
            check(species, 0);
            return Region::of_species(species);
        }
        require(kind == "everywhere" && n.empty(), "a region is everywhere, species, box or sphere, with its numbers");
        return Region::everywhere();
    }

    std::int32_t bead_species_, dissolved_;
    std::shared_ptr<SpeciesTransport> process_;
};

}  // namespace

void bind_transport(py::module_& m) {
    py::class_<TransportHandle>(m, "Transport", "Transport of dissolved species; see cpp/meso/species_transport.hpp.")
        .def(py::init<std::int32_t, std::int32_t>(), py::arg("bead_species"), py::arg("dissolved"))
        .def("set_flux", &TransportHandle::set_flux, py::arg("a"), py::arg("b"), py::arg("dissolved"), py::arg("rate"),
             py::arg("reach"), py::arg("exponent"), py::arg("noise"),
             "Exchange of a dissolved species between beads of two species.")
        .def("set_noise", &TransportHandle::set_noise, py::arg("noise"), "off, sqrt or lammps.")
        .def("add_source", &TransportHandle::add_source, py::arg("dissolved"), py::arg("rate"), py::arg("region"),
             py::arg("numbers"),
             "Amount a bead and time, everywhere, in the beads of a species, a box (x0 x1 y0 y1 z0 z1) or a sphere\n"
             "(x y z radius).")
        .def("add_reaction", &TransportHandle::add_reaction, py::arg("rate"), py::arg("reactants"), py::arg("change"),
             py::arg("bead_species") = -1,
             "Of one or two reactants; the change of every dissolved species in it; -1: in all beads.")
        .def("add_hold", &TransportHandle::add_hold, py::arg("bead_species"), py::arg("dissolved"), py::arg("value"),
             "Beads of a species keep this concentration.")
        .def("join", &TransportHandle::join, py::arg("system"), "Has the system take it in every step from now on.")
        .def_property(
            "tally", &TransportHandle::tally, &TransportHandle::set_tally,
            "What sources, reactions and held beads have given, and what these sums lost to rounding: (6, n).");
}

}  // namespace dlpoly::bind
