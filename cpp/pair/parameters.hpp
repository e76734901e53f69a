// Checks of a pair law's numbers: every refusal names the law, the parameter and what was expected.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>

#include "pair/law.hpp"

namespace dlpoly::pair {

class Parameters {
  public:
    // Exactly the law's own numbers: the drag of a FIELD record is not one of them, and a number too many is a mistake
    // that would otherwise go unnoticed.
    Parameters(const LawInfo& info, std::span<const double> values, double cutoff) : info_(info), values_(values) {
        const std::size_t expected = info.parameter_names.size();
        if (values.size() != expected) {
            std::ostringstream text;
            text << "pair law " << info.key << " takes " << expected << " numbers (";
            for (std::size_t k = 0; k < expected; ++k) text << (k == 0 ? "" : " ") << info.parameter_names[k];
            text << "), not " << values.size();
            throw std::invalid_argument(text.str());
        }
        for (std::size_t k = 0; k < expected; ++k) require(std::isfinite(values[k]), k, "a finite number");
        if (!(std::isfinite(cutoff) && cutoff > 0.0)) {
            std::ostringstream text;
            text << "pair law " << info.key << ": the cutoff must be a positive number, not " << cutoff;
            throw std::invalid_argument(text.str());
        }
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
        text << "pair law " << info_.key << ": " << info_.parameter_names[k] << " (number " << k + 1 << ") must be "
             << expected << ", not " << values_[k];
        throw std::invalid_argument(text.str());
    }

  private:
    const LawInfo& info_;
    std::span<const double> values_;
};

}  // namespace dlpoly::pair
