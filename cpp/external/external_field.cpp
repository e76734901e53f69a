// The external fields, by key (see external_field.hpp).
#include "external/external_field.hpp"

#include <stdexcept>
#include <utility>

#include "external/containing_sphere.hpp"
#include "external/electric_field.hpp"
#include "external/gravity.hpp"
#include "external/harmonic_wall.hpp"
#include "external/moving_slabs.hpp"
#include "external/opposite_halves.hpp"
#include "external/oscillating_shear.hpp"

namespace dlpoly {

std::unique_ptr<ExternalField> make_external_field(const std::string& key, std::span<const double> parameters,
                                                   std::vector<double> charges) {
    if (key == "grav") {
        return std::make_unique<Gravity>(parameters);
    }
    if (key == "oshr") {
        return std::make_unique<OscillatingShear>(parameters);
    }
    if (key == "elec" || key == "osel") {
        return std::make_unique<ElectricField>(parameters, std::move(charges), key == "osel");
    }
    if (key == "shrx") {
        return std::make_unique<MovingSlabs>(parameters);
    }
    if (key == "sphr") {
        return std::make_unique<ContainingSphere>(parameters);
    }
    if (key == "zbnd") {
        return std::make_unique<HarmonicWall>(parameters);
    }
    if (key == "pois") {
        return std::make_unique<OppositeHalves>(parameters);
    }
    throw std::invalid_argument("unknown external field '" + key + "'");
}

}  // namespace dlpoly
