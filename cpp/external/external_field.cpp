// The external fields, by key (see external_field.hpp).
#include "external/external_field.hpp"

#include <stdexcept>

#include "external/gravity.hpp"
#include "external/oscillating_shear.hpp"

namespace dlpoly {

std::unique_ptr<ExternalField> make_external_field(const std::string& key, std::span<const double> parameters) {
    if (key == "grav") {
        return std::make_unique<Gravity>(parameters);
    }
    if (key == "oshr") {
        return std::make_unique<OscillatingShear>(parameters);
    }
    throw std::invalid_argument("unknown external field '" + key + "'");
}

}  // namespace dlpoly
