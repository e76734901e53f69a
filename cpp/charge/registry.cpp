// Finding shapes and methods (see registry.hpp).
#include "charge/registry.hpp"

#include <cmath>

namespace dlpoly::charge {

namespace {

template <class Shape>
std::unique_ptr<Kernel> kernel_of(std::string_view name, Shape shape, const MethodNumbers& numbers) {
    std::unique_ptr<Kernel> kernel;
    for_each_method<Shape>([&]<class Method>() {
        if (Method::info.name != name) {
            return;
        }
        if (Shape::info.soft && !Method::info.smeared) {
            throw std::invalid_argument("the method " + std::string(name) + " has no meaning for smeared charges");
        }
        kernel = std::make_unique<KernelOf<Method>>(Method(shape, numbers));
    });
    if (kernel == nullptr) {
        throw std::invalid_argument("unknown Coulomb method '" + std::string(name) + "'");
    }
    return kernel;
}

}  // namespace

bool is_reciprocal(std::string_view method) {
    bool found = false;
    for_each_method<PointShape>(
        [&]<class Method>() { found = found || (Method::info.name == method && Method::info.reciprocal); });
    return found;
}

bool is_soft(std::string_view shape) {
    bool found = false;
    for_each_shape([&]<class Shape>() { found = found || (Shape::info.name == shape && Shape::info.soft); });
    return found;
}

std::unique_ptr<Kernel> make_kernel(std::string_view method, std::string_view shape, double length,
                                    const MethodNumbers& numbers) {
    if (!(numbers.cutoff > 0.0) || !std::isfinite(numbers.cutoff) || !(numbers.alpha >= 0.0) ||
        !std::isfinite(numbers.alpha) || !(numbers.permittivity > 0.0)) {
        throw std::invalid_argument(
            "a Coulomb method needs a cutoff and a permittivity larger than 0, and no negative alpha");
    }
    std::unique_ptr<Kernel> kernel;
    for_each_shape([&]<class Shape>() {
        if (Shape::info.name == shape) {
            kernel = kernel_of(method, Shape(length), numbers);
        }
    });
    if (kernel == nullptr) {
        throw std::invalid_argument("unknown shape of charges '" + std::string(shape) + "'");
    }
    return kernel;
}

}  // namespace dlpoly::charge
