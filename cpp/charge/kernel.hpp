// A method for one shape, behind one virtual call for a batch of pairs.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>

#include "charge/value.hpp"

namespace dlpoly::charge {

inline constexpr std::size_t batch_size = 64;

class Kernel {
  public:
    Kernel() = default;
    Kernel(const Kernel&) = delete;
    Kernel& operator=(const Kernel&) = delete;
    Kernel(Kernel&&) = delete;
    Kernel& operator=(Kernel&&) = delete;
    virtual ~Kernel() = default;

    // For `count` pairs at these squared distances: u and −u'/r of unit charges.
    virtual void evaluate(std::size_t count, const double* squared, Value* values) const = 0;

    [[nodiscard]] Value at(double r) const {
        const double squared = r * r;
        Value value{};
        evaluate(1, &squared, &value);
        return value;
    }

    // ∇²u = u'' + 2u'/r, by a difference of the factors beside r; exact to about 1e-9.
    [[nodiscard]] double laplacian(double r) const {
        constexpr double step = 1e-5;
        const double middle = at(r).factor;
        if (r == 0.0) {
            return -3.0 * middle;
        }
        const double change = at(r * (1.0 + step)).factor - at(r * (1.0 - step)).factor;
        return -3.0 * middle - change / (2.0 * step);
    }
};

template <class Method>
class KernelOf final : public Kernel {
  public:
    explicit KernelOf(const Method& method) : method_(method) {}

    void evaluate(std::size_t count, const double* squared, Value* values) const override {
        for (std::size_t k = 0; k < count; ++k) {
            values[k] = method_(std::sqrt(squared[k]));
        }
    }

  private:
    Method method_;
};

}  // namespace dlpoly::charge
