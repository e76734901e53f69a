// Checks of a pair law's numbers.
#pragma once

#include <cmath>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/law_parameters.hpp"
#include "pair/law.hpp"

namespace dlpoly::pair {

class Parameters : public LawParameters {
  public:
    // Exactly the law's own numbers: the drag of a FIELD record is not one of them, and a number too many is a mistake
    // that would otherwise go unnoticed.
    Parameters(const LawInfo& info, std::span<const double> values, double cutoff)
        : LawParameters("pair law " + std::string(info.key), info.parameter_names, values) {
        if (!(std::isfinite(cutoff) && cutoff > 0.0)) {
            std::ostringstream text;
            text << "pair law " << info.key << ": the cutoff must be a positive number, not " << cutoff;
            throw std::invalid_argument(text.str());
        }
    }
};

}  // namespace dlpoly::pair
