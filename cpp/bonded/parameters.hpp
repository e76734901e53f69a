// Checks of a bonded law's numbers.
#pragma once

#include <span>
#include <string>

#include "bonded/law.hpp"
#include "core/law_parameters.hpp"

namespace dlpoly::bonded {

class Parameters : public LawParameters {
  public:
    Parameters(const LawInfo& info, std::span<const double> values)
        : LawParameters(std::string(name(info.kind)) + " law " + std::string(info.key), info.parameter_names, values) {}
};

}  // namespace dlpoly::bonded
