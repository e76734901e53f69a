// Charges of density (3/πR³)(1 − r/R) (Groot, J. Chem. Phys. 118, 11265 (2003)).
//
// Their interaction, known as the Hankel transform of [(24 − 24 cos kR − 12 kR sin kR)/(kR)⁴]², is a polynomial in t =
// r/R on each of [0, 1] and [1, 2], over r: the transform of each product of k^(−n) with a sine or cosine is a power of
// |t + m|, and these add up to the coefficients below. It is 1/r from t = 2 on.
#pragma once

#include <array>
#include <cstddef>

#include "charge/shape.hpp"

namespace dlpoly::charge {

class LinearShape {
  public:
    static constexpr ShapeInfo info{
        .name = "linear", .description = "charges of density proportional to 1 - r/L; 1/r from 2L on", .soft = true};

    explicit LinearShape(double length) : length_(positive_length(length, "the radius of linear charges")) {}

    Value operator()(double r) const noexcept {
        const double t = r / length_;
        const double cube = length_ * length_ * length_;
        if (t < 1.0) {
            const double square = t * t;
            const double energy =
                52.0 / 35.0 + square * (-0.8 + square * (0.4 + t * (-0.1 + t * (-2.0 / 35.0 + t * (3.0 / 140.0)))));
            const double factor = 1.6 + square * (-1.6 + t * (0.5 + t * (12.0 / 35.0 + t * (-0.15))));
            return {energy / length_, factor / cube};
        }
        if (t < 2.0) {
            constexpr std::array<double, 9> c{3.0 / 35.0, 32.0 / 35.0, 1.6,        -3.2,        2.0,
                                              -0.4,       -0.1,        2.0 / 35.0, -1.0 / 140.0};
            double value = 0.0;
            double slope = 0.0;
            for (std::size_t k = c.size(); k-- > 0;) {
                slope = slope * t + value;
                value = value * t + c[k];
            }
            return {value / (t * length_), (value - t * slope) / (t * t * t * cube)};
        }
        const double inverse = 1.0 / r;
        return {inverse, inverse * inverse * inverse};
    }

  private:
    double length_;
};

}  // namespace dlpoly::charge
