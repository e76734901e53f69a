// Checks of a law's numbers: every refusal names the law, the parameter and what was expected.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace dlpoly {

class LawParameters {
  public:
    // law: what refusals call it, for example "pair law dpd"; names and values: of its numbers, all of them.
    LawParameters(std::string law, std::span<const std::string_view> names, std::span<const double> values)
        : law_(std::move(law)), names_(names), values_(values) {
        if (values.size() != names.size()) {
            std::ostringstream text;
            text << law_ << " takes " << names.size() << " numbers (";
            for (std::size_t k = 0; k < names.size(); ++k) text << (k == 0 ? "" : " ") << names[k];
            text << "), not " << values.size();
            throw std::invalid_argument(text.str());
        }
        for (std::size_t k = 0; k < names.size(); ++k) require(std::isfinite(values[k]), k, "a finite number");
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
        text << law_ << ": " << names_[k] << " (number " << k + 1 << ") must be " << expected << ", not " << values_[k];
        throw std::invalid_argument(text.str());
    }

  private:
    std::string law_;
    std::span<const std::string_view> names_;
    std::span<const double> values_;
};

}  // namespace dlpoly
