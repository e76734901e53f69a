// Electrostatics for Python: methods and shapes there are, single evaluations, the settings of a scene.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <string>
#include <utility>

#include "bind/bind.hpp"
#include "charge/charge_forces.hpp"
#include "charge/registry.hpp"

namespace py = pybind11;

namespace dlpoly::bind {

namespace {

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

py::typing::List<py::typing::Dict<py::str, py::object>> charge_shapes() {
    py::typing::List<py::typing::Dict<py::str, py::object>> shapes;
    charge::for_each_shape([&]<class Shape>() {
        py::dict entry;
        entry["name"] = std::string(Shape::info.name);
        entry["description"] = std::string(Shape::info.description);
        entry["soft"] = Shape::info.soft;
        shapes.append(entry);
    });
    return shapes;
}

py::typing::List<py::typing::Dict<py::str, py::object>> charge_methods() {
    py::typing::List<py::typing::Dict<py::str, py::object>> methods;
    charge::for_each_method<charge::PointShape>([&]<class Method>() {
        py::dict entry;
        entry["name"] = std::string(Method::info.name);
        entry["description"] = std::string(Method::info.description);
        entry["reciprocal"] = Method::info.reciprocal;
        entry["smeared"] = Method::info.smeared;
        methods.append(entry);
    });
    return methods;
}

// u and −u'/r of unit charges at distances below the cutoff.
std::pair<DoubleArray, DoubleArray> evaluate_charge(const std::string& method, const std::string& shape, double length,
                                                    const charge::MethodNumbers& numbers,
                                                    const DoubleArray& distances) {
    const auto kernel = charge::make_kernel(method, shape, length, numbers);
    const py::ssize_t count = distances.size();
    DoubleArray energies(count);
    DoubleArray factors(count);
    for (py::ssize_t k = 0; k < count; ++k) {
        const charge::Value value = kernel->at(distances.data()[k]);
        energies.mutable_data()[k] = value.energy;
        factors.mutable_data()[k] = value.factor;
    }
    return {energies, factors};
}

}  // namespace

void bind_charge(py::module_& m) {
    m.def("charge_shapes", &charge_shapes, "Every shape of charges: name, description, whether charges may coincide.");
    m.def(
        "charge_methods", &charge_methods,
        "Every Coulomb method: name, description, whether it sums over reciprocal vectors and knows smeared charges.");

    py::class_<charge::MethodNumbers>(m, "ChargeNumbers", "What Coulomb methods are made from; see cpp/charge.")
        .def(py::init<>())
        .def_readwrite("cutoff", &charge::MethodNumbers::cutoff)
        .def_readwrite("alpha", &charge::MethodNumbers::alpha)
        .def_readwrite("permittivity", &charge::MethodNumbers::permittivity);

    m.def(
        "evaluate_charge", &evaluate_charge, py::arg("method"), py::arg("shape"), py::arg("length"), py::arg("numbers"),
        py::arg("distances"),
        "u(r) and -u'(r)/r, (n,) each, of two unit charges as they act within the cutoff; of Ewald's sum the part of\n"
        "the pairs. Raises ValueError for unknown names and numbers without meaning.");

    py::class_<ChargeSettings>(m, "ChargeSettings", "The electrostatics of a scene; see cpp/charge/charge_forces.hpp.")
        .def(py::init<>())
        .def_readwrite("method", &ChargeSettings::method)
        .def_readwrite("shape", &ChargeSettings::shape)
        .def_readwrite("length", &ChargeSettings::length)
        .def_readwrite("strength", &ChargeSettings::strength)
        .def_readwrite("numbers", &ChargeSettings::numbers)
        .def_readwrite("counts", &ChargeSettings::counts)
        .def_readwrite("order", &ChargeSettings::order);
}

}  // namespace dlpoly::bind
