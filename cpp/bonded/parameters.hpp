// Checks of a bonded law's numbers: every refusal names the law, the parameter and what was expected.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "bonded/law.hpp"

namespace dlpoly::bonded {

class Parameters {
  public:
    Parameters(const LawInfo& info, std::span<const double> values) : info_(info), values_(values) {
        const std::size_t expected = info.parameter_names.size();
        if (values.size() != expected) {
            std::ostringstream text;
            text << name(info.kind) << " law " << info.key << " takes " << expected << " numbers (";
            for (std::size_t k = 0; k < expected; ++k) text << (k == 0 ? "" : " ") << info.parameter_names[k];
            text << "), not " << values.size();
            throw std::invalid_argument(text.str());
        }
        for (std::size_t k = 0; k < expected; ++k) require(std::isfinite(values[k]), k, "a finite number");
    }

    double any(std::size_t k) const { return values_[k]; }

    double positive(std::size_t k) const {
        require(values_[k] > 0.0, k, "a positive number");
        return values_[k];
    }

    double not_negative(std::size_t k) const {
        require(values_[k] >= 0.0, k, "zero or a positive number");
        return values_[k];
    }

    void require(bool holds, std::size_t k, const std::string& expected) const {
        if (holds) return;
        std::ostringstream text;
        text << name(info_.kind) << " law " << info_.key << ": " << info_.parameter_names[k] << " (number " << k + 1
             << ") must be " << expected << ", not " << values_[k];
        throw std::invalid_argument(text.str());
    }

  private:
    const LawInfo& info_;
    std::span<const double> values_;
};

}  // namespace dlpoly::bonded
