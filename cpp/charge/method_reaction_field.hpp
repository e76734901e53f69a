// Reaction field, 1/r + ½ b₀ r²/rc³ − (1 + ½ b₀)/rc with b₀ = 2(ε − 1)/(2ε + 1). Damped as DL_POLY has it: the
// force-shifted erfc(αr)/r plus ½ b₀ (r² − rc²)/rc³.
#pragma once

#include "charge/damped.hpp"
#include "charge/method.hpp"

namespace dlpoly::charge {

template <class Shape>
class ReactionField {
  public:
    static constexpr MethodInfo info{
        .name = "reaction_field",
        .description =
            "1/r + b r^2/(2 rc^3) - (1 + b/2)/rc, b = 2(eps - 1)/(2 eps + 1); damped, the force-shifted "
            "erfc(ar)/r + b (r^2 - rc^2)/(2 rc^3)",
        .reciprocal = false,
        .smeared = true};

    ReactionField(Shape shape, const MethodNumbers& numbers) : base_(shape, numbers.alpha) {
        const double cutoff = numbers.cutoff;
        const double field = 2.0 * (numbers.permittivity - 1.0) / (2.0 * numbers.permittivity + 1.0);
        const Value end = base_(cutoff);
        field_ = field / (cutoff * cutoff * cutoff);
        force_ = numbers.alpha > 0.0 ? end.factor * cutoff : 0.0;
        offset_ = end.energy + force_ * cutoff + 0.5 * field_ * cutoff * cutoff;
    }

    Value operator()(double r) const noexcept {
        Value value = base_(r);
        value.energy += 0.5 * field_ * r * r + force_ * r - offset_;
        value.factor -= field_ + (r > 0.0 ? force_ / r : 0.0);
        return value;
    }

  private:
    Damped<Shape> base_;
    double field_, force_, offset_;
};

}  // namespace dlpoly::charge
