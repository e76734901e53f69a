// The pair table under construction, so that a System is complete once it exists.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bind/require.hpp"
#include "forces/pair_table.hpp"

namespace dlpoly::bind {

class PairTableBuilder {
  public:
    explicit PairTableBuilder(std::int32_t species) : table_(species) {}

    void set_law(std::int32_t a, std::int32_t b, const std::string& key, const std::vector<double>& parameters,
                 double cutoff, bool force_shift) {
        check(a, b);
        table_.set_law(a, b, key, parameters, cutoff, force_shift);
    }
    void set_table(std::int32_t a, std::int32_t b, const std::vector<double>& energy, const std::vector<double>& virial,
                   double spacing, double cutoff, bool force_shift) {
        check(a, b);
        table_.set_table(a, b, energy, virial, spacing, cutoff, force_shift);
    }
    void set_drag(std::int32_t a, std::int32_t b, double drag, double noise, double cutoff) {
        check(a, b);
        require(drag >= 0.0 && noise >= 0.0 && std::isfinite(drag) && std::isfinite(noise),
                "drag and noise must be finite and not negative");
        require(drag == 0.0 || (cutoff > 0.0 && std::isfinite(cutoff)), "a drag needs a cutoff larger than 0");
        table_.set_drag(a, b, {drag, noise, cutoff});
    }
    PairTable take() {
        require(!taken_, "a pair table can make one system only");
        taken_ = true;
        return std::move(table_);
    }

  private:
    void check(std::int32_t a, std::int32_t b) const {
        require(!taken_, "the pair table already belongs to a system");
        require(a >= 0 && b >= 0 && a < table_.species() && b < table_.species(), "a species index is out of range");
    }
    PairTable table_;
    bool taken_ = false;
};

}  // namespace dlpoly::bind
